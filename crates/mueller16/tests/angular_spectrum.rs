//! Lists of plane waves against the coherence that they stand for, at the error that they state.

use mueller16::{AngularSpectrum, IncidentCoherence, OpeningError, PlaneWave, Tolerance};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;
use stokes::HermiteSeries;

/// Rounding of a sum of n terms of modulus 1 in all, phases up to `phase`.
fn rounding(phase: f64, size: f64) -> f64 {
    // nodes of the Gauss rules are known to 1e-15 or so, and a phase to its own size
    4e-15 * (1.0 + phase) * size
}

fn root() -> impl Strategy<Value = Matrix2<f64>> {
    let entry = || prop_oneof![4 => -1.0..1.0f64, 1 => Just(0.0), 1 => -1e-6..1e-6f64];
    (prop::array::uniform4(entry()), -2.0..2.0f64)
        .prop_map(|([a, b, c, d], e)| Matrix2::new(a, b, c, d) * 1e4 * 10f64.powf(e))
}

fn tolerance() -> impl Strategy<Value = f64> {
    (-13.0..-0.4f64).prop_map(|e| 10f64.powf(e))
}

proptest! {
    #[test]
    fn gaussian_light_keeps_its_coherence(
        root in root(), tol in tolerance(), x in -1.0..1.0f64, y in -1.0..1.0f64, size in 1e-6..1e-4f64,
    ) {
        let light = IncidentCoherence::new(root, &HermiteSeries::fundamental(1.0)).unwrap();
        let extent = [size, 0.7 * size];
        let waves = match AngularSpectrum::of_coherence(&light, extent, Tolerance::relative(tol).unwrap()) {
            Err(OpeningError::Waves { .. }) => return Ok(()),
            waves => waves.unwrap(),
        };
        prop_assert!(waves.error() <= tol);
        prop_assert!(waves.waves().iter().all(|wave| wave.weight >= 0.0));
        let x = Vector2::new(x * extent[0], y * extent[1]);
        let phase = root.amax() * size;
        let error = (waves.degree_of_coherence(&x) - light.value(&x)).norm();
        prop_assert!(error <= waves.error() + rounding(phase, 1.0), "{error:e} {:e}", waves.error());
    }

    #[test]
    fn light_of_any_series_keeps_its_coherence(
        root in root(), tol in tolerance(), order in 1usize..9, seed in prop::collection::vec(-1.0..1.0f64, 45),
        x in -1.0..1.0f64, y in -1.0..1.0f64, size in 1e-6..1e-5f64,
    ) {
        let mut real = seed[..stokes::mode_count(order)].to_vec();
        real[0] = 3.0;
        let series = HermiteSeries::from_real_coefficients(&real).unwrap();
        prop_assume!(series.sum_at_zero() > 0.3);
        let light = IncidentCoherence::new(root, &series).unwrap();
        let waves = match AngularSpectrum::of_coherence(&light, [size; 2], Tolerance::relative(tol).unwrap()) {
            Err(OpeningError::Waves { .. }) => return Ok(()),
            waves => waves.unwrap(),
        };
        let total: f64 = light.modes().real_coefficients().iter().map(|s| s.abs()).sum();
        let x = Vector2::new(x, y) * size;
        let error = (waves.degree_of_coherence(&x) - light.value(&x)).norm();
        let reach = (2.0 * (2.0 * order as f64 + 1.0).sqrt() + 17.0) * (1.0 + root.amax() * size);
        prop_assert!(error <= waves.error() + rounding(reach, total), "{error:e} {:e}", waves.error());
        prop_assert!(waves.error() <= tol.max(1e-15 * total) * 1.000_001);
    }

    #[test]
    fn uniform_sources_have_the_coherence_of_van_cittert_and_zernike(
        spread in root(), tol in tolerance(), x in -1.0..1.0f64, y in -1.0..1.0f64, size in 1e-6..1e-4f64,
    ) {
        let tol = Tolerance::relative(tol).unwrap();
        let x = Vector2::new(x, y) * size;
        let z = spread.transpose() * x;
        let phase = 2.0 * spread.amax() * size;
        let sinc = |t: f64| if t == 0.0 { 1.0 } else { t.sin() / t };
        if let Ok(waves) = AngularSpectrum::rectangle(&spread, [size; 2], tol) {
            let error = (waves.degree_of_coherence(&x) - sinc(z.x) * sinc(z.y)).norm();
            prop_assert!(waves.error() <= tol.get());
            prop_assert!(error <= waves.error() + rounding(phase, 1.0), "{error:e} {:e}", waves.error());
        }
        if phase > 200.0 {
            return Ok(());
        }
        let u = z.norm();
        let airy = if u < 1e-4 { 1.0 - u * u / 8.0 } else { 2.0 * libm::j1(u) / u };
        let waves = AngularSpectrum::disk(&spread, [size; 2], tol).unwrap();
        let error = (waves.degree_of_coherence(&x) - airy).norm();
        prop_assert!(waves.error() <= tol.get());
        prop_assert!(error <= waves.error() + rounding(phase, 1.0), "{error:e} {:e}", waves.error());
    }
}

#[test]
fn nearly_coherent_light_takes_few_waves() {
    let light = |v: f64| {
        IncidentCoherence::new(
            Matrix2::from_diagonal_element(v),
            &HermiteSeries::fundamental(1.0),
        )
        .unwrap()
    };
    let count = |phase: f64, tol: f64| {
        let tol = Tolerance::relative(tol).unwrap();
        let waves = AngularSpectrum::of_coherence(&light(phase / 1e-4), [1e-4; 2], tol).unwrap();
        waves.waves().len()
    };
    assert_eq!(count(0.0, 1e-12), 1);
    // n! Y^(2n)/(2n)! at Y = 0.1: 8e-6 for two nodes
    assert_eq!(count(0.1, 2e-5), 4);
    assert_eq!(count(0.1, 1e-5), 9);
    assert!(count(3.0, 1e-12) < 900);
}

#[test]
fn what_is_too_incoherent_is_refused_with_the_number_of_waves() {
    let light = IncidentCoherence::new(
        Matrix2::from_diagonal_element(1e9),
        &HermiteSeries::fundamental(1.0),
    );
    let tol = Tolerance::relative(1e-6).unwrap();
    let error = AngularSpectrum::of_coherence(&light.unwrap(), [1e-3; 2], tol).unwrap_err();
    assert!(matches!(error, OpeningError::Waves { needed, .. } if needed > 1e6));
    let nan = PlaneWave {
        wave_vector: Vector2::new(f64::NAN, 0.0),
        weight: 1.0,
    };
    assert!(AngularSpectrum::of_waves(vec![nan]).is_err());
    assert!(AngularSpectrum::of_waves(vec![]).is_err());
    assert!(AngularSpectrum::disk(&Matrix2::identity(), [f64::NAN, 1.0], tol).is_err());
}
