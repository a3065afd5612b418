//! Whether light can exist: series that leave the cone of Stokes vectors by amounts that are known on paper.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Vector2, Vector3};
use proptest::prelude::*;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, MAX_ORDER, ShapeMatrix, StokesVector,
    Violation, Wavelength, hermite, mode_count, mode_index, modes,
};

/// The radiance of a sum `Σ s_ab h_a h_b` of 1: `(2π/k²) |det W|^(−1/2)`.
fn radiance_unit(light: &GeneralizedStokes) -> f64 {
    let lambda = light.wavelength().metres();
    lambda * lambda / TAU / light.shape().root_determinant().sqrt()
}

fn light(components: Components) -> GeneralizedStokes {
    GeneralizedStokes::new(
        components,
        ShapeMatrix::from_root(&Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3)).unwrap(),
        Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
        Wavelength::from_metres(500e-9).unwrap(),
        2.0,
    )
    .unwrap()
}

fn unpolarized(modes: HermiteSeries) -> GeneralizedStokes {
    let stokes = StokesVector::UNPOLARIZED;
    light(Components::Shared { modes, stokes })
}

/// The series `c0 φ_00 + c2 φ_20`.
fn single_axis(c0: f64, c2: f64) -> HermiteSeries {
    HermiteSeries::from_modes(&[(0, 0, c0.into()), (2, 0, c2.into())]).unwrap()
}

#[test]
fn the_order_two_series_is_realizable_between_its_two_bounds() {
    let bound = -2f64.sqrt();
    for c2 in [bound * (1.0 - 1e-9), -1.0, -0.3, 0.0] {
        let report = unpolarized(single_axis(1.0, c2)).realizability();
        assert!(report.is_realizable(0.0), "{c2}: {report}");
        assert_eq!(report.to_string(), "realizable");
    }
    // below: negative at the centre, c0 + c2/√2; the peak of |y| e^(−y²/2) form lies at u = 2 + A/B
    let c2 = -2.0;
    let light = unpolarized(single_axis(1.0, c2));
    let report = light.realizability();
    let (a, b) = (1.0 + c2 / 2f64.sqrt(), 2f64.sqrt() * c2);
    let peak = -2.0 * b * (-0.5 * (2.0 + a / b)).exp();
    let found = report.negative_radiance.unwrap();
    assert!(
        (found.relative + a / peak).abs() < 1e-14,
        "{}",
        found.relative
    );
    assert!((found.amount + a * radiance_unit(&light) / PI.sqrt()).abs() < 1e-14 * found.amount);
    // a maximum is flat: its place is known to the root of the rounding
    let y = light.shape().fourier_dual().whiten(&found.position);
    assert!(y.norm() < 1e-7, "{y}");
    // above: negative beyond y² = 2 + A/B, by 2B e^(−(2 + A/B)/2)
    for c2 in [1.0, 0.3, 0.1] {
        let light = unpolarized(single_axis(1.0, c2));
        let report = light.realizability();
        let (a, b) = (1.0 + c2 / 2f64.sqrt(), 2f64.sqrt() * c2);
        let depth = 2.0 * b * (-0.5 * (2.0 + a / b)).exp();
        let found = report.negative_radiance.unwrap();
        assert!((found.relative / (depth / a) - 1.0).abs() < 1e-13, "{c2}");
        let y = light.shape().fourier_dual().whiten(&found.position);
        assert!(
            (y.x * y.x - 2.0 - a / b).abs() < 1e-5 && y.y.abs() < 1e-5,
            "{y}"
        );
        assert!(!report.is_realizable(0.99 * depth / a));
        assert!(report.is_realizable(1.01 * depth / a));
    }
}

/// `∫ h_n` over a box of half-width √3 standard deviations, by Simpson's rule (error below 1e-12).
fn box_coefficients(order: usize) -> Vec<f64> {
    let (half, cells) = (3f64.sqrt(), 4000);
    let step = 2.0 * half / f64::from(cells);
    (0..=order)
        .map(|n| {
            (0..=cells)
                .map(|i| {
                    let weight = match i {
                        0 => 1.0,
                        _ if i == cells => 1.0,
                        _ if i % 2 == 1 => 4.0,
                        _ => 2.0,
                    };
                    weight * hermite(n, -half + f64::from(i) * step)
                })
                .sum::<f64>()
                * step
                / 3.0
        })
        .collect()
}

#[test]
fn a_box_rings_below_zero_at_every_order() {
    for order in [4, 8, 16, 32, 64] {
        let j = box_coefficients(order);
        // a box along the first axis, the matched Gaussian across
        let mut real = vec![0.0; mode_count(order)];
        for n in 0..=order {
            real[mode_index(n, 0)] = j[n];
        }
        let report =
            unpolarized(HermiteSeries::from_real_coefficients(&real).unwrap()).realizability();
        // slow and obvious: the sum at 40,001 points of the axis
        let profile: Vec<f64> = (-20_000..=20_000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                (0..=order).map(|n| j[n] * hermite(n, t)).sum()
            })
            .collect();
        let lowest = profile.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = profile.iter().copied().fold(0.0, f64::max);
        let found = report.negative_radiance.unwrap();
        // the extremes of a function of curvature 2N+1, half a step of 1e-3 from a point
        let slack = (2 * order + 1) as f64 * 1e-6;
        assert!((found.relative + lowest / highest).abs() < slack, "{order}");
        // Gibbs: the reconstructed indicator reaches about −0.1
        assert!((-0.14..-0.06).contains(&lowest), "{order}: {lowest}");
        assert!(report.to_string().contains("the radiance is negative by"));
    }
}

#[test]
fn a_component_of_a_wider_gaussian_leaves_the_cone_at_the_centre() {
    // C3 = 0.9 e^(−w²/(2·2θ)): in w its width is √2 that of C0, at the source 1/√2 and twice as high
    let wide =
        ShapeMatrix::from_root(&(Matrix2::new(1.1e-3, 0.3e-3, -0.5e-3, 0.7e-3) / 2f64.sqrt()))
            .unwrap();
    let base = light(Components::Separate([None, None, None, None]));
    // equal values at 0 need c ∝ |det W|^(−1/2): twice the determinant ratio's root
    let (c3, lost) =
        HermiteSeries::fundamental(0.9 * 2f64.sqrt()).in_shape(&wide, base.shape(), 60);
    assert!(lost < 1e-13);
    let light = light(Components::Separate([
        Some(HermiteSeries::fundamental(1.0)),
        None,
        None,
        Some(c3),
    ]));
    assert!((light.stokes().stokes.degree_of_polarization() - 0.9).abs() < 1e-13);
    let report = light.realizability();
    let worst = report.cone_excess.unwrap();
    assert!((worst.radiance.degree_of_polarization() - 1.8).abs() < 1e-12);
    assert!((worst.relative - 0.8).abs() < 1e-12, "{report}");
    assert!(light.shape().fourier_dual().whiten(&worst.position).norm() < 1e-6);
    assert_eq!(report.negative_radiance, None);
    assert!(!report.is_realizable(0.7) && report.is_realizable(0.81));
    assert!(report.stokes_excess() < -0.09);
}

#[test]
fn light_of_one_gaussian_is_judged_by_its_stokes_vector() {
    for (stokes, excess) in [
        ([1.0, 0.0, 0.0, -1.0], None),
        ([1.0, 0.0, 0.0, 0.0], None),
        ([1.0, 0.0, 1.5, 0.0], Some(0.5)),
        ([0.0, 0.0, 0.0, 0.0], None),
    ] {
        let modes = HermiteSeries::fundamental(2.0);
        let stokes = stokes.into();
        let report = light(Components::Shared { modes, stokes }).realizability();
        let found = report.cone_excess.map_or(0.0, |found| found.relative);
        assert!((found - excess.unwrap_or(0.0)).abs() < 4.0 * f64::EPSILON);
        assert_eq!(report.negative_radiance, None);
        assert_eq!(report.is_realizable(1e-15), excess.is_none());
    }
    // on the cone but for the rounding of its numbers
    let modes = HermiteSeries::fundamental(2.0);
    let stokes = StokesVector::new(1.0, 0.6, 0.0, 0.8);
    let report = light(Components::Shared { modes, stokes }).realizability();
    assert!(report.is_realizable(f64::EPSILON), "{report}");
    // a negative intensity, in two ways
    for (c00, s0) in [(1.0, -1.0), (-1.0, 1.0)] {
        let modes = HermiteSeries::fundamental(c00);
        let stokes = StokesVector::new(s0, 0.0, 0.0, 0.0);
        let report = light(Components::Shared { modes, stokes }).realizability();
        assert_eq!(report.peak, 0.0);
        assert_eq!(report.negative_radiance.unwrap().relative, f64::INFINITY);
        let text = report.to_string();
        assert!(
            text.starts_with("not realizable: the intensity is -"),
            "{text}"
        );
        assert!(text.contains("the radiance is negative by "), "{text}");
        assert!(
            text.contains("(inf of the peak) at the source point (0e0, 0e0) m"),
            "{text}"
        );
    }
}

#[test]
fn the_worst_place_is_reported_where_its_radiance_is() {
    // lopsided on purpose: a lost sign of the position would find another radiance
    let s = [1.0, 0.9, -0.4, 0.3, 0.2, -0.1];
    let light = unpolarized(HermiteSeries::from_real_coefficients(&s).unwrap());
    let found = light.realizability().negative_radiance.unwrap();
    let there = light.generalized_radiance(&found.position);
    assert!((there.s0() + found.amount).abs() < 1e-14 * radiance_unit(&light));
    assert!((there - found.radiance).to_vector().norm() < 1e-14 * radiance_unit(&light));
    let opposite = light.generalized_radiance(&-found.position);
    assert!((opposite.s0() - there.s0()).abs() > 1e-2 * radiance_unit(&light));
}

#[test]
fn beyond_the_square_that_is_searched_nothing_is_left() {
    for order in (1..=MAX_ORDER).step_by(5) {
        let edge = ((2 * order + 1) as f64).sqrt() + 4.0;
        // no |h_b| exceeds 0.76, and beyond the turning point h_n falls
        for n in 0..=order {
            assert!(hermite(n, edge).abs() * 0.76 < 1e-6, "{order} {n}");
        }
    }
}

/// Four random series up to order 4.
fn components() -> impl Strategy<Value = [Vec<f64>; 4]> {
    prop::array::uniform4(prop::collection::vec(-1.0..1.0f64, 15))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_random_place_is_worse_than_the_one_reported(
        s in components(),
        places in prop::collection::vec(prop::array::uniform2(-5.0..5.0f64), 200),
    ) {
        let series = s.map(|real| HermiteSeries::from_real_coefficients(&real).ok());
        let light = light(Components::Separate(series));
        let report = light.realizability();
        let slack = 1e-12 * radiance_unit(&light);
        let amount = |found: Option<Violation>| found.map_or(0.0, |found| found.amount) + slack;
        for y in places {
            let m = light.shape().root().transpose() * Vector2::from(y);
            let there = light.generalized_radiance(&m);
            prop_assert!(-there.s0() <= amount(report.negative_radiance));
            prop_assert!(there.polarized_intensity() - there.s0() <= amount(report.cone_excess));
            prop_assert!(there.s0() <= report.peak + slack);
        }
    }

    #[test]
    fn a_sum_of_gaussian_sources_in_the_cone_is_realizable(
        parts in prop::collection::vec(
            (prop::array::uniform2(-0.8..0.8f64), 0.0..1.0f64, 0.0..PI, -1.5..1.5f64, 0.0..1.0f64), 1..4),
    ) {
        // each part: a Gaussian shifted by t, with a Stokes vector in the cone; s_ab ∝ t^(a+b)
        let order = 24;
        let mut sums: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; mode_count(order)]);
        for ([x, y], weight, psi, chi, degree) in parts {
            let stokes = [
                weight,
                weight * degree * chi.cos() * psi.cos(),
                weight * degree * chi.cos() * psi.sin(),
                weight * degree * chi.sin(),
            ];
            let along = |t: f64| {
                (1..=order).fold(vec![1.0], |mut powers, n| {
                    powers.push(powers[n - 1] * t / (2.0 * n as f64).sqrt());
                    powers
                })
            };
            let (p, q) = (along(x), along(y));
            for (place, (a, b)) in modes(order).enumerate() {
                for j in 0..4 {
                    sums[j][place] += stokes[j] * p[a] * q[b];
                }
            }
        }
        let series = sums.map(|real| HermiteSeries::from_real_coefficients(&real).ok());
        let report = light(Components::Separate(series)).realizability();
        // modes left out: (1.13/√2)^25/√25! < 1e-14 of the largest, a few hundred of them at most
        prop_assert!(report.is_realizable(1e-11), "{}", report);
    }
}
