//! Claim: in a medium of index n the light of wavelength λ is that of λ/n, on its way to the matter and behind it.

use super::tools::{direction, green, incident_frame, outgoing_frame};
use mueller16::{
    Autocorrelation, Channels, Energy, Footprint, Geometry, GeometryError, IncidentCoherence,
    Matter, Population,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::f64::consts::TAU;
use stokes::{
    Components, Envelope, Frame, GeneralizedStokes, HermiteSeries, ModeWidth, Mueller, ShapeMatrix,
    StokesVector,
};

#[test]
fn coherence_in_a_medium_is_finer_by_its_index() {
    let (n_i, n_o, sigma, s, l) = (1.33, 1.52, 2e-3, 0.7, 30e-6);
    let geometry = Geometry::on_plane(Vector3::z(), Vector3::z(), green())
        .unwrap()
        .between(n_i, n_o)
        .unwrap();
    let k = TAU / 550e-9;
    let frame = Frame::with_x_across(-Vector3::z(), Vector3::y()).unwrap();
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes: StokesVector::UNPOLARIZED,
        },
        ShapeMatrix::from_root(&Matrix2::from_diagonal_element(sigma)).unwrap(),
        frame,
        green(),
        s,
    )
    .unwrap();
    // van Cittert and Zernike: the transform of a Gaussian of deviation σ at n k x/s
    let gamma = |x: f64| (-0.5 * (n_i * k * sigma * x / s).powi(2)).exp();
    let envelope = Envelope::gaussian(&Matrix2::from_diagonal_element(sigma * sigma)).unwrap();
    let modes = envelope.modes(ModeWidth::VarianceMatched, 0).unwrap();
    let source = Footprint::new(envelope, [Vector3::x(), Vector3::y()], s).unwrap();
    let coherence = source.coherence(&geometry, &modes).unwrap();
    for x in [3e-6, 20e-6, 50e-6] {
        let [here, there] =
            [0.0, n_i * x].map(|x| light.at_separation(&Vector2::new(x, 0.0))[0].re);
        assert!((there / here - gamma(x)).abs() < 1e-12);
        let found = coherence.value(&Vector2::new(x, 0.0)).re;
        assert!((found - gamma(x)).abs() < 1e-12);
    }
    // R = e^(−x²/2l²): a lobe of variance 1/K, 1/K = 1/l² + (n k σ/s)², in units of (n_o/λ)²
    let variance = 1.0 / (l * l) + (n_i * k * sigma / s).powi(2);
    let phi = Vector2::new(3e4, -2e4);
    let seen = geometry.observed_at(&phi).unwrap();
    let lobe = TAU / variance * (-0.5 * phi.norm_squared() / variance).exp();
    let expected = (n_o / 550e-9).powi(2) * lobe;
    let r = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(l * l)).unwrap();
    let channels = Channels::new(&Mueller::identity(), r);
    let amplitudes = channels.amplitudes(&seen, &light).unwrap();
    let irradiance = light.stokes().stokes.to_array()[0];
    // φ² carries the rounding of k, 1e-9 of it; φ/√variance ~ 1
    let found = amplitudes.stokes(0).to_array()[0] / irradiance;
    assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    let again = source.coherence(&seen, &modes).unwrap();
    let transfer = channels.transfer(&seen, &again).unwrap().total();
    assert!((transfer.element(0, 0) / expected - 1.0).abs() < 1e-8);
}

#[test]
fn scattered_power_has_both_cosines_once() {
    let geometry =
        Geometry::on_plane(direction(50.0, 0.0), direction(20.0, 180.0), green()).unwrap();
    let (area, r, k) = (4e-6, 2.0, TAU / 550e-9);
    let lobe = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-12)).unwrap();
    let envelope = Envelope::rectangle(1e-3, 1e-3).unwrap();
    let plate = Population::of_mueller(&Mueller::identity(), lobe, envelope).unwrap();
    let matter = Matter::new(vec![plate]).unwrap();
    let modes = matter.modes(ModeWidth::VarianceMatched, 0).unwrap();
    // scaled to the power of the plate
    let modes: Vec<_> = modes.iter().map(|m| m.rescaled().unwrap().0).collect();
    let light = GeneralizedStokes::new(
        Components::Shared {
            modes: HermiteSeries::fundamental(1.0),
            stokes: StokesVector::UNPOLARIZED,
        },
        ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-6)).unwrap(),
        incident_frame(&geometry),
        green(),
        1.0,
    )
    .unwrap();
    let scattered = |energy| {
        let frame = outgoing_frame(&geometry);
        let parts = matter.scatter(&modes, &geometry, &light, energy, frame, r);
        parts.unwrap()[0].stokes().stokes.to_array()[0]
    };
    // a source of 1 µm at 1 m is a point: ∫ R e^(−iφx) d²x = 2π l² e^(−φ² l²/2)
    let phi = k * (20f64.to_radians().sin() - 50f64.to_radians().sin());
    let irradiance = light.stokes().stokes.to_array()[0];
    let expected = irradiance * area / (r * r) / 550e-9f64.powi(2)
        * TAU
        * 1e-12
        * (-0.5 * phi * phi * 1e-12).exp();
    let cosines = 20f64.to_radians().cos() * 50f64.to_radians().cos();
    let found = scattered(Energy::Printed) / expected;
    // the source's angle of 1e-6 beside the lobe's of 0.1; e^(−φ²l²/2) with an exponent of 10
    assert!((found - 1.0).abs() < 1e-8, "{found}");
    let found = scattered(Energy::Conserving) / expected / cosines;
    assert!((found - 1.0).abs() < 1e-8, "{found}");
}

#[test]
fn heights_between_equal_media_have_no_obliquity_factor() {
    let straight = |outgoing: f64| {
        let to_source = direction(40.0, 10.0);
        Geometry::on_plane(to_source, -to_source, green())
            .unwrap()
            .between(1.5, outgoing)
            .unwrap()
    };
    let error = straight(1.5).obliquity().unwrap_err();
    assert!(matches!(error, GeometryError::NoFacet { .. }), "{error}");
    assert!(Energy::HeightSurface.factor(&straight(1.5)).is_err());
    assert!(Energy::Conserving.factor(&straight(1.5)).is_ok());
    // Snell's direction at nearly equal indices: 1
    let near = straight(1.5003).observed_at(&Vector2::zeros()).unwrap();
    assert!((near.obliquity().unwrap() - 1.0).abs() < 1e-9);
}

#[test]
fn numbers_that_are_none_are_refused_wherever_light_meets_a_surface() {
    let geometry = Geometry::on_plane(Vector3::z(), Vector3::z(), green()).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
        let v = Vector3::new(bad, 0.0, 1.0);
        assert!(Geometry::on_plane(v, Vector3::z(), green()).is_err());
        assert!(Geometry::on_plane(Vector3::z(), v, green()).is_err());
        assert!(geometry.between(bad, 1.0).is_err() && geometry.between(1.0, bad).is_err());
        assert!(geometry.observed_at(&Vector2::new(bad, 0.0)).is_err());
        assert!(geometry.lit_from(v).is_err());
        let root = Matrix2::new(bad, 0.0, 0.0, 1.0);
        let modes = HermiteSeries::fundamental(1.0);
        assert!(IncidentCoherence::new(root, &modes).is_err());
        assert!(IncidentCoherence::gaussian(&geometry, &root).is_err());
    }
    assert!(geometry.between(0.0, 1.0).is_err() && geometry.between(1.0, -1.5).is_err());
}
