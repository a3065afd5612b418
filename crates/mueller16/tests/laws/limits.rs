//! Limits in which the theorem is older knowledge: plane waves, wide sources, the theorem of Van Cittert and Zernike, and
//! the shape that a source has.

use mueller16::{Autocorrelation, Channels, Energy, IncidentCoherence, Matter, Population};
use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Components, Envelope, GaussianPeak, GeneralizedStokes, ModeWidth, Mueller, StokesVector,
};

use crate::tools::{
    MICRON, blazed, dense, dense_channels, green, light, lopsided, oblique, outgoing_frame,
    root_of_size, series, skew_root,
};

#[test]
fn light_without_width_sees_the_plane_waves_lobe() {
    let scale = green().metres().powi(-2);
    for phi in [[0.0, 0.0], [6e4, -2e4], [2e5, 1e5]] {
        let geometry = oblique(phi);
        let expected = dense().to_matrix() * blazed().spectrum(&geometry.tangential()) * scale;
        let plane = dense_channels()
            .transfer(&geometry, &IncidentCoherence::plane_wave())
            .unwrap();
        // exponents of up to 10 are rounded to as many ε
        let error = (plane.total().to_matrix() - expected).amax() / expected.amax();
        assert!(error < 32.0 * f64::EPSILON, "{error:e}");
        // and is reached as the square of the width, for even series; with odd orders as the width
        for (order, power) in [(0, 2), (1, 1)] {
            let narrow = |width: f64| {
                let modes = series(order, 0.2);
                let light = IncidentCoherence::new(skew_root() * width * 1e7, &modes).unwrap();
                let found = dense_channels().transfer(&geometry, &light).unwrap();
                (found.total().to_matrix() - expected).amax() / expected.amax()
            };
            let (wide, half) = (narrow(1e-3), narrow(0.5e-3));
            let factor = wide / half;
            if phi != [0.0, 0.0] {
                assert!(
                    (factor / f64::from(1 << power) - 1.0).abs() < 1e-2,
                    "{order}: {factor}"
                );
            }
        }
        let tiny = IncidentCoherence::new(skew_root() * 1e-9, &series(5, 0.2)).unwrap();
        let found = dense_channels().transfer(&geometry, &tiny).unwrap();
        let off = (found.total().to_matrix() - expected).amax() / expected.amax();
        assert!(off < 1e-12, "{off:e}");
    }
}

#[test]
fn light_of_a_wide_source_sees_an_image_of_it() {
    // V large: R is 1 where γ is not 0, and A is the image of the source, blurred by the lobe
    let geometry = oblique([6e4, -2e4]);
    let modes = series(6, 0.3);
    let root = skew_root() * 1e10;
    let at = |r: Autocorrelation, root: Matrix2<f64>| {
        let light = IncidentCoherence::new(root, &modes).unwrap();
        let channels = Channels::new(&Mueller::identity(), r);
        channels
            .transfer(&geometry, &light)
            .unwrap()
            .total()
            .element(0, 0)
    };
    // a source as wide as a whole radian for matter of 10 µm; the mirror shows the Wigner function of the light
    for shrink in [1e2, 1e3, 1e4] {
        let scaled = root * (shrink / 1e4);
        let image = at(Autocorrelation::constant(1.0), scaled);
        let z = scaled.transpose().try_inverse().unwrap() * geometry.tangential();
        let sum = modes.real_sum(&z) / modes.sum_at_zero();
        let expected =
            std::f64::consts::TAU / scaled.determinant().abs() * sum / green().metres().powi(2);
        assert!(
            (image / expected - 1.0).abs() < 64.0 * f64::EPSILON,
            "{image:e} {expected:e}"
        );
        // blur of 1e5 rad/m beside a width of 6e5 … 6e7: of second order
        let rough = at(
            Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10)).unwrap(),
            scaled,
        );
        let blur = 1e5 / (5e5 * shrink / 1e2);
        assert!(
            (rough / image - 1.0).abs() < 40.0 * blur * blur,
            "{shrink} {}",
            rough / image - 1.0
        );
        // no speckle: another R with the same value at 0
        let other = at(
            Autocorrelation::gaussian(&Matrix2::from_diagonal_element(2e-10)).unwrap(),
            scaled,
        );
        assert!((other / rough - 1.0).abs() < 40.0 * blur * blur);
    }
}

/// Scattered light of a footprint of this profile, seen along its normal.
fn scattered(envelope: Envelope, order: usize) -> (GeneralizedStokes, f64) {
    let geometry = mueller16::Geometry::on_plane(
        crate::tools::direction(10.0, 0.0),
        nalgebra::Vector3::z(),
        green(),
    )
    .unwrap();
    let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-11)).unwrap();
    let matter = Matter::new(vec![Population::of_sixteen(&dense(), r, envelope)]).unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, order).unwrap();
    let error = modes[0].relative_error();
    let frame =
        stokes::Frame::with_x_along(nalgebra::Vector3::z(), nalgebra::Vector3::x()).unwrap();
    let light = matter
        .scatter(
            &modes,
            &geometry,
            &light(&geometry, lopsided()),
            Energy::Conserving,
            frame,
            2.0,
        )
        .unwrap();
    (light.into_iter().next().unwrap(), error)
}

/// J₁(u) by Bessel's integral, the trapezoidal rule of a periodic function.
fn j1(u: f64) -> f64 {
    let n = 200;
    (0..n)
        .map(|i| {
            let t = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            (t - u * t.sin()).cos()
        })
        .sum::<f64>()
        / f64::from(n)
}

#[test]
fn scattered_light_is_coherent_as_van_cittert_and_zernike_say_of_its_footprint() {
    let k = green().wavenumber().radians_per_metre();
    let (r, size) = (2.0, 1e-3);
    // largest deviation of |γ| along a line up to the third ring
    let deviation = |light: &GeneralizedStokes, axis: Vector2<f64>, law: &dyn Fn(f64) -> f64| {
        (0..=50)
            .map(|i| {
                let u = 0.16 * f64::from(i);
                let xi = axis * (u * r / (k * size));
                (light.degree_of_coherence(&xi) - law(u)).norm()
            })
            .fold(0.0, f64::max)
    };
    let airy = |u: f64| if u == 0.0 { 1.0 } else { 2.0 * j1(u) / u };
    let sinc = |u: f64| if u == 0.0 { 1.0 } else { u.sin() / u };
    let along = Vector2::x();
    let skew = Vector2::new(0.6, 0.8);
    let (mut disk, mut square) = (vec![], vec![]);
    for order in [0, 8, 32, 96] {
        disk.push(deviation(
            &scattered(Envelope::disk(size).unwrap(), order).0,
            skew,
            &airy,
        ));
        let light = scattered(Envelope::rectangle(size, 0.5 * size).unwrap(), order).0;
        square.push(deviation(&light, along, &sinc));
    }
    // one Gaussian does not know the rings; with modes the power at 0, to which γ refers, is what is known worst: a few per cent
    // of either sign for orders of 8 and more (a disk: −0.030, −0.044, −0.002 at orders 4, 16, 64)
    for found in [&disk, &square] {
        assert!(found[0] > 0.1, "{found:?}");
        assert!(
            found[2..].iter().all(|deviation| *deviation < 0.02),
            "{found:?}"
        );
    }
    // the law itself is that of the envelope, without modes
    for u in [0.3, 2.0, 3.8, 7.0] {
        let at = |envelope: Envelope, axis: Vector2<f64>| {
            envelope.fourier(&(axis * (u / size))) / envelope.area()
        };
        let disk = at(Envelope::disk(size).unwrap(), skew);
        let square = at(Envelope::rectangle(size, 0.5 * size).unwrap(), along);
        assert!((disk - airy(u)).norm() < 1e-14 && (square - sinc(u)).norm() < 1e-14);
    }
    // two spots of standard deviation σ, 2a apart: cos(a u) e^(−σ²u²/2), by their modes to rounding
    let spot = |x: f64| GaussianPeak {
        peak: 1.0,
        centre: Vector2::new(x * size, 0.0),
        covariance: Matrix2::from_diagonal_element((0.4 * size).powi(2)),
    };
    let (light, error) = scattered(Envelope::mixture(&[spot(-1.0), spot(1.0)]).unwrap(), 96);
    let found = deviation(&light, along, &|u| {
        u.cos() * (-0.5 * (0.4 * u).powi(2)).exp()
    });
    // an L² error of the modes of this shape, in a window of a few squares
    assert!(found < 10.0 * error + 1e-13, "{found:e} {error:e}");
    assert!(error < 1e-6);
}

#[test]
fn the_shape_is_the_curvature_of_the_logarithm_of_the_far_field() {
    // f = Σ R(0) F{I}(P w) of an oblique view of three envelopes, about no particular centre
    let geometry = oblique([2e4, 1e4]);
    let frame = outgoing_frame(&geometry);
    let p = geometry.outgoing_projection(&frame);
    let peak = |x: f64, y: f64, size: f64| {
        Envelope::mixture(&[GaussianPeak {
            peak: 1.0,
            centre: Vector2::new(x, y) * MICRON,
            covariance: root_of_size(size).transpose() * root_of_size(size),
        }])
        .unwrap()
    };
    let parts = [
        (0.7, peak(40.0, 10.0, 90.0)),
        (0.4, Envelope::rectangle(150e-6, 70e-6).unwrap()),
        (1.1, Envelope::disk(120e-6).unwrap()),
    ];
    let populations = parts.iter().map(|(weight, envelope)| {
        Population::of_sixteen(&dense(), blazed().scaled(*weight), envelope.clone())
    });
    let matter = Matter::new(populations.collect()).unwrap();
    let found = matter.shape(&p).unwrap().covariance();
    let log = |w: &Vector2<f64>| {
        let u = p * w;
        let f: Complex64 = parts
            .iter()
            .map(|(weight, e)| e.fourier(&u) * *weight)
            .sum();
        f.norm().ln()
    };
    // fourth order differences: error h⁴ · sixth derivative, which is found by doubling the step; rounding of ln f 4ε/h²
    let h = 300.0;
    let by_differences = |h: f64| {
        let along = |x: f64, y: f64| {
            let at = |s: f64| log(&(Vector2::new(x, y) * s * h));
            (16.0 * (at(1.0) + at(-1.0)) - at(2.0) - at(-2.0) - 30.0 * at(0.0)) / (12.0 * h * h)
        };
        let xy = (along(1.0, 1.0) - along(1.0, -1.0)) / 4.0;
        Matrix2::new(along(1.0, 0.0), xy, xy, along(0.0, 1.0))
    };
    let hessian = by_differences(h);
    // |f| is 1e-7 m², its logarithm 16
    let error =
        (by_differences(2.0 * h) - hessian).amax() / 4.0 + 24.0 * 16.0 * f64::EPSILON / (h * h);
    assert!(error < 1e-5 * found.amax());
    assert!(
        (found + hessian).amax() < error,
        "{found} {hessian} {error:e}"
    );
    // the centroid is the slope of the phase
    let slope = |axis: Vector2<f64>| {
        let w = axis * 0.03;
        let f: Complex64 = parts
            .iter()
            .map(|(weight, e)| e.fourier(&(p * w)) * *weight)
            .sum();
        -f.arg() / 0.03
    };
    let centre = p.transpose() * matter.centroid().unwrap();
    for (axis, expected) in [(Vector2::x(), centre.x), (Vector2::y(), centre.y)] {
        // phases of 1e-6 are known to a few ε, and their cubes are nothing
        assert!(
            (slope(axis) - expected).abs() < 1e-8 * centre.amax(),
            "{centre}"
        );
    }
}

proptest! {
    #[test]
    fn a_zero_separation_is_power_and_nothing_but_the_mueller_matrix_decides_its_polarization(
        phi in prop::array::uniform2(-1e5..1e5f64), order in 0usize..5, seed in 0.0..6.0f64,
    ) {
        let geometry = oblique(phi);
        let stokes = StokesVector::new(1.0, 0.3, -0.2, 0.5);
        let shared = Components::Shared { modes: series(order, seed), stokes };
        let out = dense_channels().amplitudes(&geometry, &light(&geometry, shared)).unwrap();
        let out = out.stokes(0).to_vector();
        let expected = (dense() * stokes).to_vector();
        let scale = out.dot(&expected) / expected.norm_squared();
        prop_assert!((out - expected * scale).amax() <= 16.0 * f64::EPSILON * out.amax());
    }
}
