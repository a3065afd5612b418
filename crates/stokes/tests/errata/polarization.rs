//! Section S4.1: what the generalized Stokes parameters say of the field, against the field itself.

use std::f64::consts::PI;

use num_complex::Complex64;
use stokes::StokesVector;

/// Cross-spectral density matrix `[Cxx, Cxy, Cyx, Cyy]` of an ensemble of fields.
type Density = [Complex64; 4];

/// `C_j = tr(σ_j C)`.
fn parameters([xx, xy, yx, yy]: Density) -> [Complex64; 4] {
    [xx + yy, xx - yy, xy + yx, Complex64::i() * (xy - yx)]
}

/// Mean over fields of `E(ξ1) E(ξ2)†`.
fn density(fields: &[impl Fn(f64) -> [Complex64; 2]], xi1: f64, xi2: f64) -> Density {
    let mut sum = [Complex64::ZERO; 4];
    for field in fields {
        let (a, b) = (field(xi1), field(xi2));
        for (i, entry) in sum.iter_mut().enumerate() {
            *entry += a[i / 2] * b[i % 2].conj() / fields.len() as f64;
        }
    }
    sum
}

fn stokes(fields: &[impl Fn(f64) -> [Complex64; 2]]) -> StokesVector {
    let [s0, s1, s2, s3] = parameters(density(fields, 0.0, 0.0)).map(|c| c.re);
    StokesVector::new(s0, s1, s2, s3)
}

/// Four plane waves, two of x- and two of y-polarization.
fn crossing_waves() -> Vec<impl Fn(f64) -> [Complex64; 2]> {
    [(1.0, true), (-1.0, true), (3.0, false), (-3.0, false)]
        .into_iter()
        .map(|(slope, along_x)| {
            move |xi: f64| {
                let wave = Complex64::new(0.0, slope * xi).exp();
                if along_x {
                    [wave, Complex64::ZERO]
                } else {
                    [Complex64::ZERO, wave]
                }
            }
        })
        .collect()
}

#[test]
fn the_cone_below_s4_6_holds_at_zero_separation_only() {
    let polarized = |c: [Complex64; 4]| c[1..].iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    let waves = crossing_waves();
    let same = parameters(density(&waves, 0.7, 0.7));
    assert!(polarized(same) <= same[0].re);
    // π/4 apart C0 = (cos π/4 + cos 3π/4)/2 vanishes and C1 does not
    let apart = parameters(density(&waves, PI / 8.0, -PI / 8.0));
    assert!(apart[0].norm() < 4.0 * f64::EPSILON);
    assert!((polarized(apart) - 0.5f64.sqrt()).abs() < 4.0 * f64::EPSILON);
}

#[test]
fn s4_9_divides_by_the_modulus_of_c0_and_not_by_its_square() {
    // intensities 1.6 and .4 without correlation: (1.6 − .4)/2
    let wave = |x: f64, y: f64| move |_: f64| [Complex64::new(x, 0.0), Complex64::new(y, 0.0)];
    let fields = [
        wave(1.6f64.sqrt(), 0.4f64.sqrt()),
        wave(1.6f64.sqrt(), -(0.4f64.sqrt())),
    ];
    let c = parameters(density(&fields, 0.0, 0.0));
    let root = c[1..].iter().map(|c| c * c).sum::<Complex64>().sqrt();
    let found = stokes(&fields).degree_of_polarization();
    assert!((found - 0.6).abs() < 4.0 * f64::EPSILON);
    let printed = (root / (c[0] * c[0])).re;
    assert!((printed - 0.3).abs() < 4.0 * f64::EPSILON);
}

#[test]
fn s4_9_takes_moduli_apart_from_zero_separation() {
    // 2 tr(C†C)/|tr C|² − 1, which any rotation of the frame leaves alone
    let tilted = |slope: f64, y: Complex64| {
        move |xi: f64| {
            let wave = Complex64::new(0.0, slope * xi).exp();
            [wave, y * wave]
        }
    };
    let fields = [
        tilted(1.0, Complex64::new(0.6, 0.3)),
        tilted(-0.4, Complex64::new(-0.2, 0.9)),
    ];
    let matrix = density(&fields, 0.5, -0.3);
    let squares: f64 = matrix.iter().map(Complex64::norm_sqr).sum();
    let trace = (matrix[0] + matrix[3]).norm_sqr();
    let expected = (2.0 * squares / trace - 1.0).sqrt();
    let c = parameters(matrix);
    let moduli = c[1..].iter().map(Complex64::norm_sqr).sum::<f64>().sqrt() / c[0].norm();
    assert!((moduli - expected).abs() < 16.0 * f64::EPSILON);
    let printed = c[1..].iter().map(|c| c * c).sum::<Complex64>().sqrt() / (c[0] * c[0]);
    let without_moduli = printed * c[0];
    assert!((printed.norm() - expected).abs() > 0.01);
    assert!((without_moduli.norm() - expected).abs() > 0.01 && without_moduli.im.abs() > 0.01);
}

/// Largest and smallest radius of the tip of `Re(E e^(iωt))`, and the angle of the largest in `[0, π)`.
fn ellipse(field: [Complex64; 2]) -> [f64; 3] {
    const STEPS: i32 = 100_000;
    let mut found = [0.0, f64::INFINITY, 0.0];
    for step in 0..STEPS {
        let turn = Complex64::new(0.0, 2.0 * PI * f64::from(step) / f64::from(STEPS)).exp();
        let [x, y] = field.map(|e| (e * turn).re);
        let radius = x.hypot(y);
        if radius > found[0] {
            found = [radius, found[1], y.atan2(x).rem_euclid(PI)];
        }
        found[1] = radius.min(found[1]);
    }
    found
}

/// A fully polarized field of intensity .6, its ellipse far from both axes.
fn elliptic() -> [Complex64; 2] {
    [
        Complex64::new(0.3, 0.1),
        Complex64::new(-0.65, 0.264_575_131_106_459_1),
    ]
}

#[test]
fn s4_10_takes_halves_of_the_polarized_and_linear_parts() {
    let field = elliptic();
    let s = stokes(&[move |_: f64| field]);
    let [major, minor, _] = ellipse(field);
    let found = s.ellipse();
    // an angle off by half a step of 2π/100,000 moves an extremal radius by its square
    let step = (2.0 * PI / 1e5f64).powi(2);
    assert!((found.semi_major - major).abs() < step);
    assert!((found.semi_minor - minor).abs() < step);
    let printed = |sign: f64| ((s.s0() + sign * s.s1().hypot(s.s2())) / s.s3().abs()).sqrt();
    assert!((printed(1.0) / major - 1.0).abs() > 0.1);
    assert!((printed(-1.0) / minor - 1.0).abs() > 0.1);
}

#[test]
fn s4_10_is_of_the_polarized_part_whatever_light_is_added() {
    let field = elliptic();
    let [s0, s1, s2, s3] = stokes(&[move |_: f64| field]).to_array();
    let [major, minor, _] = ellipse(field);
    let found = StokesVector::new(s0 + 2.0, s1, s2, s3).ellipse();
    let step = (2.0 * PI / 1e5f64).powi(2);
    assert!((found.semi_major - major).abs() < step && (found.semi_minor - minor).abs() < step);
}

#[test]
fn s4_11_needs_the_quadrant() {
    let field = elliptic();
    let s = stokes(&[move |_: f64| field]);
    let [.., angle] = ellipse(field);
    // the time of the largest radius is known to a step
    let step = 2.0 * PI / 1e5 * 4.0;
    assert!(s.s1() < 0.0, "the case where the two differ");
    assert!((s.angle_of_linear_polarization() - angle).abs() < step);
    let printed = (0.5 * (s.s2() / s.s1()).atan()).rem_euclid(PI);
    // off by a right angle: the minor axis
    assert!(((printed - angle).abs() - PI / 2.0).abs() < step);
}
