//! Section S3: the Wigner distribution of light in Hermite-Gauss space, written out with whitened modes.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};
use num_complex::Complex64;
use stokes::{HermiteSeries, ShapeMatrix, modes, whitened_mode};

use crate::far_apart;
use crate::quadrature::{Integral, fourier, integral};

const WAVENUMBER: f64 = 2.3;
/// Roundings in ε for the shape used here, of condition number 6.
const ROUNDINGS: f64 = 256.0;

/// Light with even and odd orders, at a distance r: `C(ξ) = Σ c φ((k/r) ξ)/r²`.
struct Light {
    series: HermiteSeries,
    shape: ShapeMatrix,
    distance: f64,
}

impl Light {
    fn at(distance: f64) -> Self {
        let real = [1.0, 0.4, -0.2, 0.1, 0.05, -0.15, 0.02, 0.06, -0.03, 0.01];
        Self {
            series: HermiteSeries::from_real_coefficients(&real).expect("ten coefficients"),
            shape: ShapeMatrix::from_root(&Matrix2::new(1.3, -0.4, 0.5, 0.7)).expect("a root"),
            distance,
        }
    }

    /// C at a transverse separation.
    fn coherence(&self, xi: &Vector2<f64>) -> Complex64 {
        self.series
            .value(&self.shape, &(xi * WAVENUMBER / self.distance))
            / self.distance.powi(2)
    }

    /// Separations whose whitened coordinates are of size 1.
    fn separations(&self) -> Matrix2<f64> {
        self.shape.root().try_inverse().expect("a root") * self.distance / WAVENUMBER
    }

    /// (S3.1) by quadrature.
    fn transform(&self, zeta: &Vector2<f64>) -> Integral {
        fourier(&self.separations(), zeta, |xi| self.coherence(xi))
    }

    /// (S3.3): `(2π/k²) Σ (−i)^(a+b) c_ab φ_ab((r/k) ζ; W^(−T))`.
    fn wigner(&self, zeta: &Vector2<f64>) -> Complex64 {
        self.radiance(&(zeta * self.distance / WAVENUMBER))
    }

    /// The same as a function of the place x on the source.
    fn radiance(&self, x: &Vector2<f64>) -> Complex64 {
        let dual = self.shape.fourier_dual();
        let sum: Complex64 = modes(self.series.order())
            .map(|(a, b)| {
                let turned =
                    Complex64::new(0.0, -1.0).powu((a + b) as u32) * self.series.coefficient(a, b);
                turned * whitened_mode(a, b, &dual, x)
            })
            .sum();
        2.0 * PI / WAVENUMBER.powi(2) * sum
    }
}

#[test]
fn s3_3_is_right_and_real_with_odd_orders_in_it() {
    let light = Light::at(3.7);
    assert!(light.series.has_odd_orders());
    for zeta in [Vector2::new(0.5, -0.2), Vector2::new(-0.3, 0.8)] {
        let found = light.transform(&zeta);
        assert!(found.is(light.wigner(&zeta), ROUNDINGS));
        assert!(
            found.is(found.value.re.into(), ROUNDINGS),
            "{found:?} is not real"
        );
    }
}

#[test]
fn property_1_of_s3_odd_orders_do_not_vanish_but_tell_one_side_of_the_source_from_the_other() {
    let light = Light::at(3.7);
    let real: Vec<f64> = modes(light.series.order())
        .map(|(a, b)| {
            if (a + b) % 2 == 0 {
                light.series.real_coefficient(a, b)
            } else {
                0.0
            }
        })
        .collect();
    let even = Light {
        series: HermiteSeries::from_real_coefficients(&real).unwrap(),
        ..Light::at(3.7)
    };
    let zeta = Vector2::new(0.5, -0.2);
    let (right, left) = (light.transform(&zeta), light.transform(&-zeta));
    assert!(far_apart(right.value, left.value));
    // without odd orders both sides look the same: light would have moved from one to the other
    let mean = even.transform(&zeta);
    assert!(mean.is(even.transform(&-zeta).value, ROUNDINGS));
    assert!(far_apart(right.value, mean.value));
    // nor does it decay: the odd part keeps its share at any distance
    let share = |distance: f64| {
        let light = Light::at(distance);
        let zeta = zeta * 3.7 / distance;
        let (right, left) = (
            light.transform(&zeta).value.re,
            light.transform(&-zeta).value.re,
        );
        (right - left) / (right + left)
    };
    assert!((share(3.7e6) / share(3.7) - 1.0).abs() < 1e-12);
}

#[test]
fn s3_4_needs_the_constant_of_the_inverse_transform_and_no_distance() {
    let light = Light::at(3.7);
    let frequencies = light.separations().try_inverse().unwrap().transpose();
    let intensity = light.coherence(&Vector2::zeros());
    let corrected = integral(&frequencies, |zeta| light.wigner(zeta) / (4.0 * PI * PI));
    assert!(corrected.is(intensity, ROUNDINGS));
    let printed = integral(&(frequencies / light.distance), |xi| {
        light.wigner(&(xi * light.distance))
    });
    assert!(far_apart(intensity, printed.value));
    // nor does either of the two corrections do alone
    assert!(far_apart(intensity, printed.value / (4.0 * PI * PI)));
    assert!(far_apart(intensity, corrected.value * (4.0 * PI * PI)));
}

#[test]
fn s3_5_is_constant_along_the_ray_as_a_function_of_the_place_on_the_source() {
    let x = Vector2::new(0.5, -0.9);
    let (near, far) = (Light::at(3.7), Light::at(37.0));
    let along = |light: &Light| light.transform(&(x * WAVENUMBER / light.distance));
    assert!(along(&near).is(near.radiance(&x), ROUNDINGS));
    assert!(along(&far).is(near.radiance(&x), ROUNDINGS));
    // as printed, W(r; kζ) would be the same function of ζ at any distance
    let printed = |light: &Light| light.transform(&(x * WAVENUMBER));
    assert!(far_apart(printed(&near).value, near.radiance(&x)));
    assert!(far_apart(printed(&near).value, printed(&far).value));
}

#[test]
fn the_argument_of_s3_5_is_minus_the_place_on_the_source() {
    // a point source at m: the phase between two receivers by the distances themselves
    let (k, r, m) = (1e4, 1e3, 0.4);
    let distance = |xi: f64| (xi - m).hypot(r);
    let xi = 1e-2;
    let phase = k * (distance(0.5 * xi) - distance(-0.5 * xi));
    // C = e^(i phase) has its transform at ζ = phase/ξ, hence at x = (r/k) ζ
    let x = r / k * phase / xi;
    assert!((x + m).abs() < 1e-4, "{x}");
    // and a Gaussian source around m has its radiance there
    let centred = |w: &Vector2<f64>| Complex64::new(-0.5 * w.norm_squared(), -m * w.x).exp();
    let at = |x: f64| {
        fourier(&Matrix2::identity(), &Vector2::new(x, 0.0), centred)
            .value
            .re
    };
    assert!(at(-m) > at(-m + 0.1) && at(-m) > at(-m - 0.1));
}
