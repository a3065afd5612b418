//! Tests of the kernel.

use super::*;
use num_complex::Complex64;

const ROOT: Matrix2<f64> = Matrix2::new(1.1, 0.4, -0.3, 0.8);
const LIGHT: Matrix2<f64> = Matrix2::new(0.7, -0.5, 0.2, 0.9);

fn sum_in<T: Real>(
    family: &GaussianFamily,
    v: &Matrix2<f64>,
    phi: &Vector2<f64>,
    series: &HermiteSeries,
    tolerance: Option<Tolerance>,
) -> f64 {
    let request = Request::new([Some(series)], tolerance);
    let mut sums = [0.0];
    let meeting = Meeting::new(family, v, plane::determinant(v));
    meeting.add::<T, 1>(phi, &request, &mut sums).unwrap();
    sums[0]
}

fn ramp(order: usize) -> HermiteSeries {
    let s: Vec<_> = (0..stokes::mode_count(order))
        .map(|i| (i as f64 + 0.3).sin())
        .collect();
    HermiteSeries::from_real_coefficients(&s).unwrap()
}

/// `∫ e^(−xᵀS⁻¹x/2) h_a h_b(Vx) e^(−iφ·x) d²x` by the trapezoidal rule.
fn quadrature(
    s: &Matrix2<f64>,
    v: &Matrix2<f64>,
    phi: &Vector2<f64>,
    [a, b]: [usize; 2],
) -> Complex64 {
    let (half, step) = (240_i32, 0.05);
    let inverse = plane::inverse(s);
    let mut sum = Complex64::ZERO;
    for i in -half..=half {
        for j in -half..=half {
            let x = Vector2::new(f64::from(i), f64::from(j)) * step;
            let y = v * x;
            let f = (-0.5 * x.dot(&(inverse * x))).exp()
                * stokes::hermite(a, y.x)
                * stokes::hermite(b, y.y);
            sum += Complex64::cis(-phi.dot(&x)) * f;
        }
    }
    sum * step * step
}

#[test]
fn modes_are_the_fourier_integral() {
    let phi = Vector2::new(1.3, -0.6);
    let term = GaussianTerm {
        weight: 1.0,
        rate: 1.7,
        shift: Vector2::new(0.4, 0.3),
    };
    // and with axes of light and matter along each other
    let apart = (
        Matrix2::new(1.1, 0.0, 0.0, 0.6),
        Matrix2::new(0.7, 0.0, 0.0, -0.9),
    );
    for (root, v) in [(ROOT, LIGHT), apart] {
        let family = GaussianFamily::new(&root, [term]).unwrap();
        let s = root.transpose() * root / 1.7;
        for [a, b] in [
            [0, 0],
            [1, 0],
            [0, 1],
            [2, 0],
            [1, 1],
            [3, 2],
            [0, 5],
            [4, 3],
        ] {
            let mut series = vec![0.0; stokes::mode_count(a + b)];
            series[stokes::mode_index(a, b)] = 1.0;
            let series = HermiteSeries::from_real_coefficients(&series).unwrap();
            let g = sum_in::<f64>(&family, &v, &phi, &series, None);
            let expected = quadrature(&s, &v, &(phi - term.shift), [a, b]);
            let found = Complex64::new(0.0, -1.0).powu((a + b) as u32) * g;
            // the trapezoidal rule is exact for a Gaussian to e^(−π²/(h² K⁻¹)); 231,361 roundings of numbers ≤ 0.6
            assert!(
                (found - expected).norm() < 1e-13,
                "{a} {b}: {found} {expected}"
            );
        }
    }
}

fn terms(count: usize) -> Vec<GaussianTerm> {
    (0..count)
        .map(|i| {
            let i = i as f64;
            GaussianTerm {
                weight: (i + 0.5).cos(),
                rate: 0.3 + i,
                // some with a common centre
                shift: Vector2::new((0.5 * i).floor(), -0.3 * (0.5 * i).floor()),
            }
        })
        .collect()
}

#[test]
fn a_family_is_the_sum_of_its_gaussians_bit_by_bit() {
    let phi = Vector2::new(1.3, -0.6);
    for order in [0, 3, 20] {
        let series = ramp(order);
        for count in [1, 2, 4, 5, 11] {
            let terms = terms(count);
            let of = |terms: &[GaussianTerm]| {
                let family = GaussianFamily::new(&ROOT, terms.iter().copied()).unwrap();
                sum_in::<f64>(&family, &LIGHT, &phi, &series, None)
            };
            let one_by_one = terms.chunks(1).fold(0.0, |sum, term| sum + of(term));
            assert_eq!(of(&terms), one_by_one, "{order} {count}");
        }
    }
}

#[test]
fn families_side_by_side_are_each_what_they_are_alone() {
    let phi = Vector2::new(1.3, -0.6);
    for order in [0, 3, 20, 70] {
        let series = ramp(order);
        // the second with axes along the light's: M₁₂ = 0 in one lane alone
        let families: [_; LANES] = std::array::from_fn(|l| {
            let root = if l == 1 {
                plane::inverse(&LIGHT).transpose()
            } else {
                ROOT * (1.0 + l as f64)
            };
            GaussianFamily::new(&root, [terms(4)[l]]).unwrap()
        });
        let meetings = families
            .each_ref()
            .map(|f| Meeting::new(f, &LIGHT, plane::determinant(&LIGHT)));
        let request = Request::new([Some(&series)], None);
        let together = Meeting::side_by_side::<f64, LANES>(&meetings, &phi, &request).unwrap();
        for (family, found) in families.iter().zip(together) {
            assert_eq!(
                found,
                sum_in::<f64>(family, &LIGHT, &phi, &series, None),
                "{order}"
            );
        }
    }
}

#[test]
fn what_a_tolerance_leaves_out_is_below_it() {
    let mut left_out = 0;
    for order in [0, 1, 4, 9, 30] {
        let series = ramp(order);
        let norm: f64 = series.real_coefficients().iter().map(|s| s.abs()).sum();
        for tolerance in [1e-12, 1e-6, 1e-2] {
            for step in 0..60 {
                let phi = Vector2::new(0.3, 0.5) * f64::from(step);
                for v in [LIGHT, LIGHT * 30.0, LIGHT * 0.01] {
                    let family =
                        GaussianFamily::new(&ROOT, [GaussianTerm::centred(2.0, 1.7)]).unwrap();
                    let asked = Some(Tolerance::relative(tolerance).unwrap());
                    let found = sum_in::<f64>(&family, &v, &phi, &series, asked);
                    let whole = sum_in::<f64>(&family, &v, &phi, &series, None);
                    let flat = HermiteSeries::fundamental(1.0);
                    let peak = sum_in::<f64>(&family, &v, &Vector2::zeros(), &flat, None);
                    let limit = tolerance * norm * peak;
                    assert!((found - whole).abs() <= limit, "{order} {tolerance} {phi}");
                    left_out += usize::from(found == 0.0 && whole != 0.0);
                }
            }
        }
    }
    assert!(left_out > 500, "{left_out}");
}

#[test]
fn single_precision_is_good_to_2e_5_of_the_lobe() {
    for order in [0, 1, 4, 8, 16, 33, 64] {
        let series = ramp(order);
        let norm: f64 = series.real_coefficients().iter().map(|s| s.abs()).sum();
        for v in [LIGHT, LIGHT * 30.0, LIGHT * 0.03] {
            let family = GaussianFamily::new(&ROOT, terms(7)).unwrap();
            let peak: f64 = terms(7)
                .into_iter()
                .map(|t| {
                    let centred = GaussianTerm::centred(t.weight.abs(), t.rate);
                    let family = GaussianFamily::new(&ROOT, [centred]).unwrap();
                    let flat = HermiteSeries::fundamental(1.0);
                    sum_in::<f64>(&family, &v, &Vector2::zeros(), &flat, None)
                })
                .sum();
            for step in 0..40 {
                let phi = Vector2::new(0.31, -0.47) * f64::from(step);
                let single = sum_in::<f32>(&family, &v, &phi, &series, None);
                let double = sum_in::<f64>(&family, &v, &phi, &series, None);
                let error = (single - double).abs() / (peak * norm);
                assert!(error < 2e-5, "{order} {phi}: {error:e}");
            }
        }
    }
}

#[test]
fn a_delta_is_refused_and_no_distance_makes_nonsense() {
    let family = GaussianFamily::new(&ROOT, [GaussianTerm::centred(1.0, 0.0)]).unwrap();
    let flat = HermiteSeries::fundamental(1.0);
    let request = Request::new([Some(&flat)], None);
    for v in [Matrix2::zeros(), Matrix2::new(1.0, 0.0, 0.0, 0.0)] {
        let meeting = Meeting::new(&family, &v, 0.0);
        assert_eq!(
            meeting.add::<f64, 1>(&Vector2::zeros(), &request, &mut [0.0]),
            None
        );
    }
    for far in [1e3, 1e30, 1e200, f64::MAX, f64::INFINITY] {
        for v in [LIGHT, LIGHT * 1e20] {
            let phi = Vector2::new(far, -far);
            let found = sum_in::<f64>(&family, &v, &phi, &ramp(6), None);
            assert!(found.is_finite(), "{far}");
        }
    }
}
