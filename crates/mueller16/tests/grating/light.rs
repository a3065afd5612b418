//! Gratings in light of finite width, and under roughness.

use std::f64::consts::TAU;

use mueller16::{
    Autocorrelation, Blaze, Channels, Flat, Geometry, Grating, IncidentCoherence, Mount, Profile,
    Relief, Superposed, Tolerance,
};
use nalgebra::{Matrix2, Vector2, Vector3};
use stokes::{Mueller, Wavelength};

const AXES: [Vector3<f64>; 2] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];

/// A surface of Gaussian-correlated roughness, `R = e^(−g) + (1 − e^(−g)) e^(−x²/2l²)`, as a relief of its own.
struct Haze(f64);

impl Relief for Haze {
    fn autocorrelation(
        &self,
        phi_z: f64,
        tolerance: Tolerance,
    ) -> Result<(Autocorrelation, mueller16::Approximation), mueller16::AutocorrelationError> {
        let mirror = (-(phi_z * self.0).powi(2)).exp();
        let (flat, exact) = Flat.autocorrelation(phi_z, tolerance)?;
        let diffuse = Autocorrelation::gaussian(&Matrix2::from_diagonal_element(1e-10))?;
        Ok((
            flat.scaled(mirror).plus(&diffuse.scaled(1.0 - mirror)),
            exact,
        ))
    }

    fn slope_covariance(&self) -> Option<Matrix2<f64>> {
        None
    }
}

#[test]
fn roughness_leaves_lines_and_surrounds_them_with_haloes() {
    let (phi_z, sigma) = (2e7, 3e-8);
    let profile = Profile::sinusoidal(1.5e-7).unwrap();
    let grating = Grating::lines(2e-6, Vector2::x(), profile.clone()).unwrap();
    let tolerance = Tolerance::relative(1e-9).unwrap();
    let (r, _) = Superposed(grating.clone(), Haze(sigma))
        .autocorrelation(phi_z, tolerance)
        .unwrap();
    let g = (phi_z * sigma).powi(2);
    assert!((r.at_zero() - 1.0).abs() < 1e-9 && (r.delta_weight() - (-g).exp()).abs() < 1e-9);
    for q in -2..=2 {
        let share = profile.amplitude(phi_z, q).norm_sqr();
        let place = grating.shift([q, 0]);
        let (weight, _) = r
            .deltas()
            .find(|(_, at)| (at - place).norm() < 1.0)
            .unwrap();
        assert!((weight - share * (-g).exp()).abs() < 1e-15);
        // the halo's peak 2π l²; the neighbours are 31 deviations away
        let expected = share * (1.0 - (-g).exp()) * TAU * 1e-10;
        assert!((r.spectrum(&place) / expected - 1.0).abs() < 1e-12);
    }
}

#[test]
fn through_the_theorem_each_order_carries_its_share() {
    // light of 1 mrad; the pitch sends orders 0.2 rad apart, 200 deviations
    let wavelength = Wavelength::from_metres(500e-9).unwrap();
    let grating = Grating::lines(
        2.5e-6,
        Vector2::new(0.6, 0.8),
        Profile::blazed(1.6e-7, Blaze::Rising).unwrap(),
    );
    let grating = grating.unwrap();
    let source = Vector3::new(
        0.3f64.sin() * 1f64.cos(),
        0.3f64.sin() * 1f64.sin(),
        0.3f64.cos(),
    );
    let mount = Mount::reflection(source, AXES, wavelength, 1.0).unwrap();
    let mut carried = 0.0;
    for order in grating.orders(&mount).unwrap() {
        let phi_z = order.geometry.normal_component();
        let tolerance = Tolerance::relative(1e-3).unwrap();
        let (r, _) = grating.autocorrelation(phi_z, tolerance).unwrap();
        let matter = Channels::new(&Mueller::identity(), r);
        let angular = Matrix2::from_diagonal_element(1e-3);
        let centre = order.geometry.to_observer();
        let (n, half) = (32, 7.5e-3);
        let step = 2.0 * half / f64::from(n);
        let mut sum = 0.0;
        for i in 0..=n {
            for j in 0..=n {
                // ∫ T cos_o dω = ∫ T d²o_t; trapezoidal, exact but for the tail e^(−28)
                let x = centre.x + f64::from(i) * step - half;
                let y = centre.y + f64::from(j) * step - half;
                let z = (1.0 - x * x - y * y).sqrt();
                if z.is_nan() {
                    continue;
                }
                let geometry =
                    Geometry::on_plane(source, Vector3::new(x, y, z), wavelength).unwrap();
                let light = IncidentCoherence::gaussian(&geometry, &angular).unwrap();
                sum += matter
                    .transfer(&geometry, &light)
                    .unwrap()
                    .total()
                    .element(0, 0);
            }
        }
        // orders within 7.5 mrad of the horizon would be cut
        if centre.z > 0.15 {
            let found = sum * step * step;
            assert!(
                (found - order.share).abs() < 1e-10,
                "{:?}: {found} {}",
                order.index,
                order.share
            );
            carried += found;
        }
    }
    assert!(carried > 0.5);
}
