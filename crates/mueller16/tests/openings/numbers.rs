//! Numbers that make no openings, light or scatterers are refused, and what is not refused answers.

use csdm::JonesMatrix;
use mueller16::{
    AngularSpectrum, Geometry, Opening, Openings, PlaneWave, PointScatterer, PointScatterers,
    Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use num_complex::Complex64;
use proptest::prelude::*;
use stokes::{
    Components, Frame, GeneralizedStokes, HermiteSeries, ShapeMatrix, StokesVector, Wavelength,
};

fn green() -> Wavelength {
    Wavelength::from_metres(550e-9).unwrap()
}

/// Anything that is an f64.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1.0, 1.5, 5e-324, 1e-300, -1e-9, 1e-7,
            1e30, -1e300, f64::MAX,
        ]),
        1 => any::<f64>(),
        2 => -2.0..2.0f64,
    ]
}

fn slit() -> Openings {
    Openings::new(vec![Opening::clear(Vector2::zeros(), 1e-5, 1e-5)], 1e-8).unwrap()
}

#[test]
fn no_light_gives_no_light() {
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(0.0),
            stokes: StokesVector::UNPOLARIZED,
        },
        ShapeMatrix::isotropic(1e-6).unwrap(),
        Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
        green(),
        1.0,
    )
    .unwrap();
    let geometry = Geometry::on_plane(-Vector3::z(), Vector3::z(), green()).unwrap();
    let seen = slit()
        .scatter(&geometry, &light, Tolerance::ROUNDING)
        .unwrap();
    assert_eq!(seen.to_array(), [0.0; 4]);
}

#[test]
fn one_phase_needs_distances_and_counts_the_media() {
    let straight = Geometry::on_plane(-Vector3::z(), Vector3::z(), green()).unwrap();
    let tolerance = Tolerance::relative(1e-3).unwrap();
    for distance in [f64::NAN, 0.0, -1.0, f64::NEG_INFINITY] {
        let found = slit().check_global_phase(&straight, [distance, 1.0], tolerance);
        assert!(
            found
                .unwrap_err()
                .to_string()
                .contains("expected a positive length")
        );
    }
    // k e²/2r = 2.9e-4 rad at 1 m from a corner at 5√2 µm, of which water makes 4/3
    let just = 0.5 * green().wavenumber().radians_per_metre() * 5e-11 / 1e-3;
    let far = [f64::INFINITY, just * 1.1];
    assert!(slit().check_global_phase(&straight, far, tolerance).is_ok());
    let water = straight.between(1.0, 1.33).unwrap();
    assert!(slit().check_global_phase(&water, far, tolerance).is_err());
}

#[test]
fn sources_beside_a_view_are_asked_whether_they_are_far() {
    // an opening 10 cm aside: 14 cm from the source's middle, 3.5 cm from where an oblique wave comes
    let opening = Opening::clear(Vector2::new(0.1, 0.0), 1e-5, 1e-5);
    let screen = Openings::new(vec![opening], 1.0).unwrap();
    let phase = |s: f64| 0.25 * green().wavenumber().radians_per_metre() * 1e-10 * (1.0 / s + 1e-3);
    let limit = Tolerance::relative(phase(0.1)).unwrap();
    let view = screen
        .seen_between(Vector3::z() * 0.1, -Vector3::z() * 1e3, green(), limit)
        .unwrap();
    let wave = |sine: f64| {
        let k = green().wavenumber().radians_per_metre();
        let wave_vector = Vector2::new(sine * k, 0.0);
        AngularSpectrum::of_waves(vec![PlaneWave {
            wave_vector,
            weight: 1.0,
        }])
        .unwrap()
    };
    assert!(view.transfer_of(&wave(0.0)).is_ok() && view.transfer_of(&wave(-0.9)).is_ok());
    assert!(view.transfer_of(&wave(0.9)).is_err());
}

proptest! {
    #[test]
    fn no_number_makes_openings_panic(n in prop::array::uniform8(wild())) {
        let opening = Opening {
            centre: Vector2::new(n[0], n[1]),
            width: n[2],
            height: n[3],
            jones: JonesMatrix::new(Complex64::new(n[4], n[5]), n[6].into(), n[7].into(), Complex64::ONE),
        };
        let _ = Openings::new(vec![opening], n[7]);
        let _ = slit().seen_between(Vector3::new(n[0], n[1], n[2]), Vector3::new(n[3], n[4], n[5]), green(), Tolerance::ROUNDING)
            .and_then(|view| view.between(n[6], n[7]));
        let scatterer = PointScatterer { place: Vector3::new(n[0], n[1], n[2]), strength: n[3], jones: opening.jones };
        let _ = PointScatterers::new(vec![scatterer]);
    }

    #[test]
    fn no_number_makes_light_panic(n in prop::array::uniform6(wild())) {
        let spread = Matrix2::new(n[0], n[1], n[2], n[3]);
        let tolerance = Tolerance::relative(1e-3).unwrap();
        for light in [
            AngularSpectrum::rectangle(&spread, [n[4], n[5]], tolerance),
            AngularSpectrum::disk(&spread, [n[4], n[5]], tolerance),
        ].into_iter().flatten() {
            prop_assert!((light.degree_of_coherence(&Vector2::zeros()) - 1.0).norm() < 1e-10);
        }
        let wave = PlaneWave { wave_vector: Vector2::new(n[0], n[1]), weight: n[2] };
        let _ = AngularSpectrum::of_waves(vec![wave]);
        let _ = slit().points([n[0] * 1e6, n[1] * 1e6], tolerance);
    }
}

#[test]
fn radiant_intensity_has_both_cosines_and_the_area() {
    // straight behind and at 60° from light at 60°: a slit so small that its transform is its area to 1e-9
    let slit = Openings::new(vec![Opening::clear(Vector2::zeros(), 1e-11, 1e-11)], 1e-8).unwrap();
    let light = AngularSpectrum::plane_wave();
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let oblique = Vector3::new(sin, 0.0, cos);
    let geometry = Geometry::on_plane(-oblique, Vector3::z(), green()).unwrap();
    let seen = slit
        .lit_by(&light)
        .unwrap()
        .pattern(&geometry, &[Vector3::z(), oblique])
        .unwrap();
    let expected = (1e-22f64 / 550e-9).powi(2);
    for (found, cosines) in seen.iter().zip([0.5, 0.25]) {
        let ratio = found.element(0, 0) / (expected * cosines);
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}
