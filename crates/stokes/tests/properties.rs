//! What holds for any light: random roots up to cond Θ = 1e12, orders to 64, 300 nm to 10 cm, distances to 1e9 m.
//!
//! Tolerances are roundings times what the entries of the root multiply them by, [`Case::rounding`].
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use nalgebra::{Matrix2, Vector2, Vector3, Vector4};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, LEAST_FAR_FIELD, LightError, Mueller,
    ShapeMatrix, StokesVector, Wavelength, mode_count,
};

const EPS: f64 = f64::EPSILON;

fn turn(angle: f64) -> Matrix2<f64> {
    let (sin, cos) = angle.sin_cos();
    Matrix2::new(cos, sin, -sin, cos)
}

/// One light and what its errors scale with.
#[derive(Clone, Debug)]
struct Case {
    light: GeneralizedStokes,
    /// A separation at which the light is not negligible, m.
    separation: Vector2<f64>,
    /// The source point of the same whitened coordinates, m.
    position: Vector2<f64>,
    order: usize,
    /// Condition number of the root.
    condition: f64,
}

impl Case {
    /// Relative error of a sum of modes whose root is rounded once more.
    ///
    /// `N` roundings of the recurrence; half the relative error of the determinant, `ε·cond W`; and `√(2N+1)`, the
    /// slope of the modes, times the error of whitened coordinates: up to `ε·cond W` times their length, which is
    /// below 6 here.
    fn rounding(&self) -> f64 {
        let slope = ((2 * self.order + 1) as f64).sqrt();
        EPS * (32.0 * (1 + self.order) as f64 + self.condition * (4.0 + 48.0 * slope))
    }

    /// The L² norm of the light's four series over their shape: what values are measured by.
    fn norm(&self) -> f64 {
        (0..4)
            .filter_map(|j| self.light.components().series(j))
            .map(|series| series.norm().powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// Largest value that a light of this norm reaches, up to a factor near `√N`.
    fn scale(&self) -> f64 {
        self.norm() * self.light.shape().root_determinant().sqrt()
            / (self.light.distance() * self.light.distance())
    }

    /// The same for radiances.
    fn radiance_scale(&self) -> f64 {
        let lambda = self.light.wavelength().metres();
        self.norm() * lambda * lambda / self.light.shape().root_determinant().sqrt()
    }
}

fn series(order: usize) -> impl Strategy<Value = HermiteSeries> {
    prop::collection::vec(
        prop_oneof![-1.0..1.0f64, Just(0.0), -1e-9..1e-9f64],
        mode_count(order),
    )
    .prop_map(|real| HermiteSeries::from_real_coefficients(&real).unwrap())
}

fn orders() -> impl Strategy<Value = usize> {
    prop_oneof![4 => 0usize..7, 2 => 7usize..25, 1 => 25usize..=64]
}

fn components() -> impl Strategy<Value = Components> {
    orders().prop_flat_map(|order| {
        prop_oneof![
            (series(order), prop::array::uniform4(-1.0..1.0f64)).prop_map(|(modes, stokes)| {
                Components::Shared {
                    modes,
                    stokes: stokes.into(),
                }
            }),
            (
                series(order),
                series(order / 2),
                series(0),
                any::<[bool; 4]>()
            )
                .prop_map(move |(a, b, c, there)| {
                    let all = [a.clone(), b, c, a.scaled(-0.5)];
                    let mut j = 0;
                    Components::Separate(all.map(|series| {
                        j += 1;
                        there[j - 1].then_some(series)
                    }))
                }),
        ]
    })
}

/// Frames of random directions.
fn frame() -> impl Strategy<Value = Frame> {
    prop::array::uniform6(-1.0..1.0f64).prop_filter_map("parallel", |v| {
        Frame::with_x_along(
            Vector3::new(v[0], v[1], v[2]),
            Vector3::new(v[3], v[4], v[5]),
        )
        .ok()
    })
}

fn case() -> impl Strategy<Value = Case> {
    (
        components(),
        (
            -4.0..0.0f64,
            prop_oneof![0.0..6.0f64, Just(0.0), 0.0..1e-9f64],
        ),
        (-10.0..10.0f64, -10.0..10.0f64),
        frame(),
        (-6.52..-1.0f64, 0.0..1.0f64),
        prop::array::uniform2(-4.0..4.0f64),
    )
        .prop_map(
            |(components, (width, thinness), (left, right), frame, (wavelength, far), y)| {
                let (width, condition) = (10f64.powf(width), 10f64.powf(thinness));
                let root =
                    turn(left) * Matrix2::new(width, 0.0, 0.0, width / condition) * turn(right);
                let wavelength = Wavelength::from_metres(10f64.powf(wavelength)).unwrap();
                let k = wavelength.wavenumber().radians_per_metre();
                let nearest = 1.001 * LEAST_FAR_FIELD / k;
                let distance = nearest * (1e9 / nearest).powf(far);
                let shape = ShapeMatrix::from_root(&root).unwrap();
                let y = Vector2::from(y);
                Case {
                    separation: shape.unwhiten(&y) * (distance / k),
                    position: root.transpose() * y,
                    order: components.order(),
                    condition,
                    light: GeneralizedStokes::new(components, shape, frame, wavelength, distance)
                        .unwrap(),
                }
            },
        )
}

fn close(a: [Complex64; 4], b: [Complex64; 4], tolerance: f64) -> Result<(), TestCaseError> {
    for (a, b) in a.into_iter().zip(b) {
        prop_assert!(
            (a - b).norm() <= tolerance,
            "{a} {b}: off by {}, tolerance {tolerance}",
            (a - b).norm()
        );
    }
    Ok(())
}

fn near(a: StokesVector, b: StokesVector, tolerance: f64) -> Result<(), TestCaseError> {
    let off = (a - b).to_vector().amax();
    prop_assert!(
        off <= tolerance,
        "{a:?} {b:?}: off by {off}, tolerance {tolerance}"
    );
    Ok(())
}

/// The same light by the root `u W`.
fn rerooted(light: &GeneralizedStokes, u: &Matrix2<f64>) -> GeneralizedStokes {
    let turned = |series: &HermiteSeries| series.with_root_turned_by(u);
    let components = match light.components() {
        Components::Shared { modes, stokes } => Components::Shared {
            modes: turned(modes),
            stokes: *stokes,
        },
        Components::Separate(series) => {
            Components::Separate(series.each_ref().map(|series| series.as_ref().map(turned)))
        }
    };
    let shape = light.shape().with_root_turned_by(u).unwrap();
    GeneralizedStokes::new(
        components,
        shape,
        *light.frame(),
        light.wavelength(),
        light.distance(),
    )
    .unwrap()
}

proptest! {
    #[test]
    fn there_and_back_in_frames_changes_nothing(case in case(), angle in -10.0..10.0f64) {
        let light = &case.light;
        let turned = light.in_frame(light.frame().turned(angle)).unwrap();
        let back = turned.in_frame(*light.frame()).unwrap();
        let tolerance = case.rounding() * case.scale();
        close(back.at_separation(&case.separation), light.at_separation(&case.separation), tolerance)?;
        near(back.stokes().stokes, light.stokes().stokes, tolerance)?;
        // and in the turned frame the same two points, written there, have the same C0 and C3
        let there = turned.at_separation(&(turn(angle) * case.separation));
        let here = light.at_separation(&case.separation);
        for j in [0, 3] {
            prop_assert!((there[j] - here[j]).norm() <= tolerance);
        }
        let (sin, cos) = (2.0 * angle).sin_cos();
        prop_assert!((there[1] - (here[1] * cos + here[2] * sin)).norm() <= tolerance);
        prop_assert!((there[2] - (here[2] * cos - here[1] * sin)).norm() <= tolerance);
    }

    #[test]
    fn the_opposite_separation_has_the_conjugate(case in case()) {
        let there = case.light.at_separation(&case.separation);
        let opposite = case.light.at_separation(&-case.separation);
        prop_assert_eq!(opposite, there.map(|c| c.conj()));
    }

    #[test]
    fn what_a_truncation_keeps_and_loses_make_the_whole(case in case(), order in 0usize..64) {
        let (kept, loss) = case.light.truncated(order);
        let whole = case.norm();
        let kept_norm = Case { light: kept.clone(), ..case.clone() }.norm();
        prop_assert!((kept_norm.hypot(loss.norm * whole) - whole).abs() <= 8.0 * EPS * whole);
        let sum = kept.stokes().stokes + loss.stokes;
        near(sum, case.light.stokes().stokes, 4.0 * EPS * 30.0 * case.scale())?;
        prop_assert!(order < case.order || loss.norm == 0.0);
    }

    #[test]
    fn the_choice_of_root_is_invisible(case in case(), angle in -10.0..10.0f64, mirror in any::<bool>()) {
        let light = &case.light;
        let mut u = turn(angle);
        if mirror {
            u *= Matrix2::new(0.0, 1.0, 1.0, 0.0);
        }
        let other = rerooted(light, &u);
        let tolerance = case.rounding() * case.scale();
        let xi = &case.separation;
        close(other.at_separation(xi), light.at_separation(xi), tolerance)?;
        near(other.stokes().stokes, light.stokes().stokes, tolerance)?;
        prop_assert!((other.intensity() - light.intensity()).abs() <= tolerance);
        let tolerance = case.rounding() * case.radiance_scale();
        near(
            other.generalized_radiance(&case.position),
            light.generalized_radiance(&case.position),
            tolerance,
        )?;
        let k = light.wavelength().wavenumber().radians_per_metre();
        let zeta = case.position * (k / light.distance());
        near(other.wigner(&zeta), light.wigner(&zeta), tolerance)?;
        // degrees are ratios: the error of each part over the denominator
        let at_zero = case.rounding() * case.scale() / light.intensity();
        if at_zero > 0.0 && at_zero < 0.1 {
            let gamma = light.degree_of_coherence(xi);
            let difference = (other.degree_of_coherence(xi) - gamma).norm();
            prop_assert!(difference <= 2.0 * at_zero * (1.0 + gamma.norm()));
        }
        let there = case.rounding() * case.scale() / light.at_separation(xi)[0].norm();
        if there < 0.1 {
            let degree = light.degree_of_cross_polarization(xi);
            let difference = (other.degree_of_cross_polarization(xi) - degree).abs();
            prop_assert!(difference <= 4.0 * there * (1.0 + degree));
        }
    }

    #[test]
    fn the_choice_of_root_moves_no_coherence_ellipse(case in case(), angle in -10.0..10.0f64) {
        let light = &case.light;
        let other = rerooted(light, &turn(angle));
        if let Ok(ellipse) = light.coherence_ellipse() {
            // curvatures are sums of (2N+1)-fold terms over C0, their squares from the gradient, and weigh against the
            // least curvature, in whitened coordinates at least (r/(k σ semi_major))², σ the larger width
            let k = light.wavelength().wavenumber().radians_per_metre();
            let theta = light.shape().theta();
            let narrow = 1.0 / (0.5 * (theta.m11 + theta.m22)).sqrt();
            let weakest = light.distance() / (k * narrow * case.condition * ellipse.semi_major);
            let terms = case.scale() / light.intensity() * (2 * case.order + 1) as f64
                * (mode_count(case.order) as f64).sqrt();
            let tolerance = case.rounding() * (terms / weakest).powi(2);
            if tolerance < 1e-2 {
                let again = other.coherence_ellipse();
                prop_assert!(again.is_ok(), "{again:?}");
                let again = again.unwrap();
                prop_assert!((again.semi_major / ellipse.semi_major - 1.0).abs() <= tolerance);
                prop_assert!((again.semi_minor / ellipse.semi_minor - 1.0).abs() <= tolerance);
            }
        }
    }

    #[test]
    fn superposition_is_linear(case in case(), factor in -3.0..3.0f64, m in prop::array::uniform16(-1.0..1.0f64)) {
        let light = &case.light;
        let element = Mueller::from_rows([
            [m[0], m[1], m[2], m[3]], [m[4], m[5], m[6], m[7]],
            [m[8], m[9], m[10], m[11]], [m[12], m[13], m[14], m[15]],
        ]);
        let other = light.through(&element, *light.frame()).unwrap();
        let (here, through) = (light.at_separation(&case.separation), other.at_separation(&case.separation));
        // every operation rounds each coefficient once, of moduli that add up to 16 norms
        let tolerance = 64.0 * EPS * (1 + case.order) as f64 * case.scale();
        let expected = std::array::from_fn(|l| (0..4).map(|j| here[j] * element.element(l, j)).sum());
        close(through, expected, tolerance)?;
        let sum = light.plus(&other.scaled(factor).unwrap()).unwrap();
        let expected = std::array::from_fn(|j| here[j] + through[j] * factor);
        close(sum.at_separation(&case.separation), expected, 4.0 * tolerance)?;
    }

    #[test]
    fn propagation_touches_no_coefficient(case in case(), further in 1.0..1e6f64) {
        let light = &case.light;
        let far = light.clone().propagated_to(light.distance() * further).unwrap();
        prop_assert_eq!(far.components(), light.components());
        prop_assert_eq!(far.shape(), light.shape());
        prop_assert_eq!(far.frame(), light.frame());
        // C(ξ; r₂) = (r₁/r₂)² C(ξ r₁/r₂; r₁)
        let ratio = far.distance() / light.distance();
        let expected = light.at_separation(&case.separation).map(|c| c / (ratio * ratio));
        let tolerance = case.rounding() * case.scale() / (ratio * ratio);
        close(far.at_separation(&(case.separation * ratio)), expected, tolerance)?;
        prop_assert_eq!(far.generalized_radiance(&case.position), light.generalized_radiance(&case.position));
    }

    #[test]
    fn an_absent_component_is_a_series_of_zeros(case in case(), padded in 0usize..9) {
        let light = &case.light;
        let with = |components| GeneralizedStokes::new(
            components, *light.shape(), *light.frame(), light.wavelength(), light.distance(),
        ).unwrap();
        let series: [Option<HermiteSeries>; 4] = std::array::from_fn(|j| light.components().series(j));
        // the same numbers, with zeros for what is absent and for orders beyond the last
        let full = series.each_ref().map(|series| {
            let mut real = series.as_ref().map_or_else(Vec::new, |series| series.real_coefficients().to_vec());
            let order = series.as_ref().map_or(0, HermiteSeries::order) + padded;
            real.resize(mode_count(order.min(64)).max(real.len()), 0.0);
            HermiteSeries::from_real_coefficients(&real).ok()
        });
        let (absent, present) = (with(Components::Separate(series)), with(Components::Separate(full)));
        prop_assert_eq!(absent.at_separation(&case.separation), present.at_separation(&case.separation));
        prop_assert_eq!(absent.stokes(), present.stokes());
        prop_assert_eq!(
            absent.generalized_radiance(&case.position), present.generalized_radiance(&case.position));
        // and a shared light is the same as its components one by one, to the rounding of the products
        let tolerance = 8.0 * EPS * (1 + case.order) as f64 * case.scale();
        close(absent.at_separation(&case.separation), light.at_separation(&case.separation), tolerance)?;
        near(absent.stokes().stokes, light.stokes().stokes, tolerance)?;
        near(
            absent.generalized_radiance(&case.position),
            light.generalized_radiance(&case.position),
            8.0 * EPS * (1 + case.order) as f64 * case.radiance_scale(),
        )?;
    }

    #[test]
    fn light_is_described_in_the_far_field_only(wavelength in -6.52..-1.0f64, distance in -9.0..9.0f64) {
        let (wavelength, distance) = (Wavelength::from_metres(10f64.powf(wavelength)).unwrap(), 10f64.powf(distance));
        let components = Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes: Vector4::new(1.0, 0.0, 0.0, 0.0).into(),
        };
        let found = GeneralizedStokes::new(
            components,
            ShapeMatrix::isotropic(1.0).unwrap(),
            Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
            wavelength,
            distance,
        );
        let kr = wavelength.wavenumber().radians_per_metre() * distance;
        prop_assert_eq!(found.is_ok(), kr >= 100.0);
        if let Err(error) = found {
            let expected = LightError::NotFarField { distance, wavelength: wavelength.metres(), kr };
            prop_assert_eq!(error, expected);
        }
    }
}
