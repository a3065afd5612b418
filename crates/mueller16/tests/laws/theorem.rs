//! The theorem against the integrals of its proof.

use mueller16::{Autocorrelation, Channels, Energy, Geometry, Matter, Population};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use stokes::{
    Components, Envelope, Frame, GaussianPeak, GeneralizedStokes, HermiteSeries, ModeWidth,
    Mueller, StokesVector,
};

use crate::tools::{
    MICRON, blazed, dense, dense_channels, light, lopsided, oblique, outgoing_frame, over_plane,
    root_of_size, series,
};

/// A separation in the surface as the light's transverse plane sees it.
fn across(frame: &Frame, x: &Vector2<f64>) -> Vector2<f64> {
    let x = Vector3::new(x.x, x.y, 0.0);
    Vector2::new(frame.x().dot(&x), frame.y().dot(&x))
}

/// `(1/λ²) ∫ R(x) C'_j(x) e^(−iφ·x) d²x`.
fn amplitude(
    r: &Autocorrelation,
    light: &GeneralizedStokes,
    geometry: &Geometry,
    j: usize,
) -> crate::tools::Integral {
    let phi = geometry.tangential();
    let per_area = geometry.wavelength().metres().powi(-2);
    // ± 9 of the longest length, 30 points in each of the shortest
    over_plane(220, &(Matrix2::identity() * 0.6 * MICRON), |x| {
        let c = light.at_separation(&across(light.frame(), x))[j];
        r.value(x) * c * Complex64::cis(-phi.dot(x)) * per_area
    })
}

#[test]
fn amplitudes_are_the_integrals_over_separations_of_the_light_on_the_surface() {
    for phi in [[0.0, 0.0], [5e4, -3e4], [-1.2e5, 9e4]] {
        let geometry = oblique(phi);
        for components in [
            lopsided(),
            Components::Shared {
                modes: series(4, 0.7),
                stokes: StokesVector::new(1.0, 0.3, -0.2, 0.5),
            },
            Components::Separate([Some(series(2, 0.1)), None, None, Some(series(6, 0.5))]),
        ] {
            let light = light(&geometry, components);
            let found = dense_channels().amplitudes(&geometry, &light).unwrap();
            for j in 0..4 {
                if light.components().series(j).is_none() {
                    continue;
                }
                let integral = amplitude(&blazed(), &light, &geometry, j);
                for l in 0..4 {
                    let per_m = found.channel(j, l, 0) / dense().element(l, j);
                    // 882 additions on the way of a term, and some roundings of its phase of up to 10 rad
                    assert!(
                        integral.is(per_m, 1000.0),
                        "{j} → {l}: {per_m:e} {integral:?}"
                    );
                }
            }
        }
    }
}

/// Two envelopes' worth of scatterers, one of them off the centre and lopsided.
fn lopsided_envelope() -> Envelope {
    let peak = |peak, x: f64, y: f64, size: f64| GaussianPeak {
        peak,
        centre: Vector2::new(x, y) * MICRON,
        covariance: root_of_size(size).transpose() * root_of_size(size),
    };
    Envelope::mixture(&[peak(1.0, 11.0, -4.0, 9.0), peak(1.2, -14.0, 6.0, 6.0)]).unwrap()
}

#[test]
fn scattered_light_is_the_integral_over_pairs_of_points() {
    // C_l(ξ) = 1/(λr)² ∫∫ I((x₁+x₂)/2) R(x₁−x₂) Σ M_lj C'_j(x₁−x₂) e^(−ip₁·x₁ + ip₂·x₂),  p = φ ± (k/2r) P ξ
    let geometry = oblique([4e4, -6e4]);
    let light = light(&geometry, lopsided());
    let envelope = lopsided_envelope();
    let r = Autocorrelation::of_family(
        &root_of_size(8.0),
        [mueller16::GaussianTerm {
            weight: 0.8,
            rate: 1.0,
            shift: Vector2::new(2e4, 1e4),
        }],
    )
    .unwrap();
    let matter = Matter::new(vec![Population::of_sixteen(
        &dense(),
        r.clone(),
        envelope.clone(),
    )])
    .unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, 40).unwrap();
    let truncation = modes[0].relative_error();
    let frame = outgoing_frame(&geometry);
    let distance = 0.5;
    let found = matter
        .scatter(&modes, &geometry, &light, Energy::Printed, frame, distance)
        .unwrap();
    let xi = Vector2::new(5.3e-3, -2.4e-3);
    let found_c = found[0].at_separation(&xi);

    let k = geometry.wavelength().wavenumber().radians_per_metre();
    let w = geometry.outgoing_projection(&frame) * xi * (k / distance);
    let phi = geometry.tangential();
    let (p1, p2) = (phi + w * 0.5, phi - w * 0.5);
    let (step, half) = (4.5 * MICRON, 13);
    let points: Vec<Vector2<f64>> = (-half..=half)
        .flat_map(|i| (-half..=half).map(move |j| Vector2::new(f64::from(i), f64::from(j)) * step))
        .collect();
    let centre = envelope.centroid();
    let m = dense().to_matrix().map(Complex64::from);
    let mut sum = nalgebra::Vector4::<Complex64>::zeros();
    for i in -2 * half..=2 * half {
        for j in -2 * half..=2 * half {
            // all pairs of one separation see the same light
            let d = Vector2::new(f64::from(i), f64::from(j)) * step;
            let here = r.value(&d);
            if here.norm() < 1e-17 {
                continue;
            }
            let c = light.at_separation(&across(light.frame(), &d));
            let mut pairs = Complex64::ZERO;
            for x2 in &points {
                let x1 = x2 + d;
                if x1.amax() > f64::from(half) * step * 1.001 {
                    continue;
                }
                let phase = p2.dot(x2) - p1.dot(&x1);
                pairs += Complex64::cis(phase) * envelope.value(&((x1 + x2) * 0.5 + centre));
            }
            sum += m * nalgebra::Vector4::from(c) * here * pairs;
        }
    }
    let scale = step.powi(4) / (geometry.wavelength().metres() * distance).powi(2);
    let most = found[0]
        .at_separation(&Vector2::zeros())
        .map(Complex64::norm);
    for (l, (found, expected)) in found_c.iter().zip(sum.iter()).enumerate() {
        let expected = expected * scale;
        // the truncated modes; and the rim of the points, where a Gaussian of 10 µm has fallen to e^(−(58/10)²/2) = 5e-8
        let tolerance = (truncation + 1e-6) * most[l].max(expected.norm());
        assert!(
            (found - expected).norm() < tolerance,
            "{l}: {found} {expected} {truncation:e}"
        );
        assert!(
            expected.im.abs() > 1e-2 * expected.norm(),
            "an imaginary part is at stake"
        );
    }
}

#[test]
fn amplitudes_are_averages_of_the_plane_waves_lobe_over_the_source() {
    // A = (1/(λs)²) S_j M_lj ∫ I(m) F{R}(φ + Cᵀm) d²m, light of a lopsided source by its modes
    let geometry = oblique([3e4, 2e4]);
    let frame = crate::tools::incident_frame(&geometry);
    let source = lopsided_envelope();
    let s = 5e-4;
    let tangents = [frame.x(), frame.y()];
    let modes = source.modes(ModeWidth::VarianceMatched, 40).unwrap();
    let truncation = modes.relative_error();
    let stokes = StokesVector::new(1.0, 0.3, -0.2, 0.5);
    let light = modes
        .light(
            stokes,
            &Matrix2::identity(),
            frame,
            geometry.wavelength(),
            s,
        )
        .unwrap();
    let found = dense_channels().amplitudes(&geometry, &light).unwrap();
    let k = geometry.wavelength().wavenumber().radians_per_metre();
    let c = Matrix2::from_fn(|i, j| tangents[i].dot(&geometry.tangents()[j])) * (k / s);
    let average = over_plane(120, &(Matrix2::identity() * 0.8 * MICRON), |m| {
        let at = geometry.tangential() + c.transpose() * (m - source.centroid());
        Complex64::from(source.value(m) * blazed().spectrum(&at))
    });
    let scale = (geometry.wavelength().metres() * s).powi(-2);
    for j in 0..4 {
        for l in 0..4 {
            let expected = average.value.re * scale * stokes.to_array()[j] * dense().element(l, j);
            let found = found.channel(j, l, 0);
            // an L² error bounds that of a smooth average up to the ratio of norms, below 10 here
            assert!(
                (found - expected).abs() < (10.0 * truncation + 1e-12) * expected.abs(),
                "{j} → {l}: {found:e} {expected:e}"
            );
        }
    }
    // the other side of the source would be seen elsewhere
    let mirrored = over_plane(120, &(Matrix2::identity() * 0.8 * MICRON), |m| {
        let at = geometry.tangential() - c.transpose() * (m - source.centroid());
        Complex64::from(source.value(m) * blazed().spectrum(&at))
    });
    assert!((mirrored.value.re / average.value.re - 1.0).abs() > 1e-2);
}

#[test]
fn amplitudes_are_linear_in_light_and_in_matter() {
    let geometry = oblique([5e4, -3e4]);
    let (a, b) = (
        light(&geometry, lopsided()),
        light(
            &geometry,
            Components::Shared {
                modes: series(4, 0.7),
                stokes: StokesVector::new(1.0, 0.3, -0.2, 0.5),
            },
        ),
    );
    let channels = dense_channels();
    let of = |channels: &Channels, light: &GeneralizedStokes| {
        channels
            .amplitudes(&geometry, light)
            .unwrap()
            .stokes(0)
            .to_vector()
    };
    let sum = a.scaled(0.3).unwrap().plus(&b).unwrap();
    let separately = of(&channels, &a) * 0.3 + of(&channels, &b);
    // 21 modes, four channels and three Gaussians, some roundings each; no term is larger than the norms of the light
    let size = separately.amax() + of(&channels, &a).amax() + of(&channels, &b).amax();
    assert!((of(&channels, &sum) - separately).amax() < 100.0 * f64::EPSILON * size);

    let more = Mueller::identity();
    let wide = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-11)).unwrap();
    let both = dense_channels().with(&more, wide.clone(), 0);
    let separately = of(&channels, &a) + of(&Channels::new(&more, wide), &a);
    assert!((of(&both, &a) - separately).amax() < 100.0 * f64::EPSILON * size);
}

#[test]
fn a_first_order_mode_has_the_sign_that_its_place_on_the_source_says() {
    // a source moved by +m along x: s_10 < 0, and the lobe moves by −Cᵀm; the recurrence must agree
    let geometry = oblique([0.0, 0.0]);
    let frame = crate::tools::incident_frame(&geometry);
    let s = 1.0;
    let centred = HermiteSeries::from_real_coefficients(&[1.0]).unwrap();
    let moved = HermiteSeries::from_real_coefficients(&[1.0, -0.1, 0.0]).unwrap();
    let of = |modes: HermiteSeries, geometry: &Geometry| {
        let stokes = StokesVector::UNPOLARIZED;
        let light = GeneralizedStokes::new(
            Components::Shared { modes, stokes },
            stokes::ShapeMatrix::from_root(&crate::tools::skew_root()).unwrap(),
            frame,
            geometry.wavelength(),
            s,
        )
        .unwrap();
        let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10)).unwrap();
        let amplitudes = Channels::new(&Mueller::identity(), r).amplitudes(geometry, &light);
        amplitudes.unwrap().stokes(0).s0()
    };
    // m = W^T e_x · 0.1 √2/... : only the side counts. ζ = −(k/s) m, so that the lobe is larger toward −Cᵀm
    let m = crate::tools::skew_root().transpose() * Vector2::new(1.0, 0.0);
    let k = geometry.wavelength().wavenumber().radians_per_metre();
    let [e1, e2] = [frame.x(), frame.y()];
    let tangential = |v: Vector3<f64>| Vector2::new(v.x, v.y);
    let toward = tangential(e1) * m.x + tangential(e2) * m.y;
    let toward = toward.normalize() * (0.01 * k / s);
    let at = |sign: f64| oblique((toward * sign).into());
    let ratio = |sign: f64| of(moved.clone(), &at(sign)) / of(centred.clone(), &at(sign));
    assert!(
        ratio(-1.0) > 1.001 && ratio(1.0) < 0.999,
        "{} {}",
        ratio(-1.0),
        ratio(1.0)
    );
}
