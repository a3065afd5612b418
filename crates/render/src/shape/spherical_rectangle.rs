//! The rectangle that a point sees on the sphere of its directions, and points on it that are uniform in solid angle.
//!
//! The height of the plane over the point is the unit of length, the sides are at x₀ < x₁ and y₀ < y₁ from the foot of the
//! perpendicular. A corner is the complex number c(x, y) = √(1 + x² + y²) + i x y, of argument
//! asin(xy/(√(1 + x²) √(1 + y²))). Then
//!
//! ```text
//! S = arg(c₁₁ c₁₀* c₀₀ c₀₁*),   e^(ik) = −c₀₁ c₀₀*/|c₀₁ c₀₀|,   φ = k + u S
//! x = c/√(1 − c²),              c = ±1/√(f² + b₀²),             f = (b₀ cos φ − b₁)/sin φ
//! y = √(1 + x²) g/√(1 − g²),    g = (1 − v) g₀ + v g₁
//! ```
//!
//! with b₀ = −y₀/√(1 + y₀²), b₁ = y₁/√(1 + y₁²), gᵢ = yᵢ/√(1 + x² + yᵢ²) and the sign of f for c. Products of corners
//! instead of sums of angles: one arc tangent for S, and none for k.
//!
//! Source: Ureña, Fajardo, King, An Area-Preserving Parametrization for Spherical Rectangles, Computer Graphics Forum
//! 32(4), 2013.
//!
//! The algebra is in double precision, since thin and far rectangles are differences of corners; arc tangent, sine and
//! cosine are in single precision and cost 3e-7 of S. Shares of S are covered within 2e-6; of less than 1e-6 sr
//! too few digits are left for that.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use num_complex::Complex64;

/// Least solid angle that is sampled.
pub(super) const LEAST: f32 = 1e-6;

/// A rectangle as seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalRectangle {
    /// In heights.
    x: [f64; 2],
    y: [f64; 2],
    height: f64,
    /// e^(ik).
    start: Complex64,
    solid_angle: f32,
}

impl SphericalRectangle {
    /// From the sides and the height over the point, which must be positive; `None` if less than [`LEAST`] is seen, or if
    /// the sides are more than 1e18 heights away.
    #[inline]
    pub(super) fn new(x: [f64; 2], y: [f64; 2], height: f64) -> Option<Self> {
        let unit = height.recip();
        let (x, y) = (x.map(|x| x * unit), y.map(|y| y * unit));
        let corner = |i: usize, j: usize| {
            let (x, y) = (x[i], y[j]);
            Complex64::new((1.0 + x * x + y * y).sqrt(), x * y)
        };
        let start = -corner(0, 1) * corner(0, 0).conj();
        let whole = -corner(1, 1) * corner(1, 0).conj() * start.conj();
        let mut solid_angle = argument(whole);
        // more than π is only seen by who stands under it
        if solid_angle < 0.0 && x[0] < 0.0 && x[1] > 0.0 && y[0] < 0.0 && y[1] > 0.0 {
            solid_angle += TAU;
        }
        (solid_angle >= LEAST).then(|| Self {
            x,
            y,
            height,
            start: start * start.norm_sqr().sqrt().recip(),
            solid_angle,
        })
    }

    /// Steradians.
    #[inline]
    pub(super) fn solid_angle(&self) -> f32 {
        self.solid_angle
    }

    /// A point uniform in solid angle, from the foot of the perpendicular.
    #[inline]
    pub(super) fn point(&self, [u, v]: [f32; 2]) -> [f64; 2] {
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        let (sin, cos) = (0.5 * u * self.solid_angle).sin_cos();
        let half = Complex64::new(f64::from(cos), f64::from(sin));
        // of modulus 1 but for rounding in single precision
        let phi = self.start * half * half * (2.0 - half.norm_sqr());
        let [near0, near1] = [y0, y1].map(|y| (1.0 + y * y).sqrt().recip());
        let f = -y0 * near0 * phi.re - y1 * near1;
        // (f² + b₀² sin²φ)(1 − c²), with f times sin φ
        let rest = f * f - (phi.im * near0).powi(2);
        let x = (phi.im * f.signum() / rest.max(0.0).sqrt()).clamp(x0, x1);
        let across = 1.0 + x * x;
        let [g0, g1] = [y0, y1].map(|y| y / (across + y * y).sqrt());
        let g = g0 + f64::from(v) * (g1 - g0);
        let y = g * (across / (1.0 - g * g).max(0.0)).sqrt();
        [x * self.height, y.clamp(y0, y1) * self.height]
    }
}

/// The argument of a complex number in (−π, π], relative error below 3e-7.
///
/// An odd polynomial of least relative error for arc tangents up to π/4.
#[inline]
fn argument(z: Complex64) -> f32 {
    let (x, y) = (z.re.abs(), z.im.abs());
    let steep = y > x;
    let ratio = (if steep { x / y } else { y / x }) as f32;
    let p = [
        -0.00469327294,
        0.0242523963,
        -0.0594863904,
        0.0991429321,
        -0.140194813,
        0.19969724,
        -0.333319908,
        0.999999901,
    ];
    let square = ratio * ratio;
    let within = ratio * p.iter().fold(0.0, |sum, c| sum * square + c);
    let acute = if steep { FRAC_PI_2 - within } else { within };
    let angle = if z.re < 0.0 { PI - acute } else { acute };
    angle.copysign(z.im as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solid angle by the sum of four arc tangents, one a corner.
    fn by_arc_tangents(x: [f64; 2], y: [f64; 2], h: f64) -> f64 {
        let corner = |x: f64, y: f64| (x * y).atan2(h * (h * h + x * x + y * y).sqrt());
        corner(x[1], y[1]) - corner(x[1], y[0]) - corner(x[0], y[1]) + corner(x[0], y[0])
    }

    /// Sides and heights: above and beside, near and far, thin, grazing, huge and tiny.
    fn views() -> Vec<([f64; 2], [f64; 2], f64)> {
        let sides = [
            [-1.0, 1.0],
            [-0.01, 3.0],
            [0.0, 0.5],
            [0.5, 0.7],
            [-4.0, -3.0],
            [2.0, 2.001],
        ];
        let mut views = Vec::new();
        for x in sides {
            for y in sides {
                for h in [1e-4, 1e-2, 0.3, 5.0] {
                    for scale in [1e-9, 1.0, 1e9] {
                        views.push((x.map(|a| a * scale), y.map(|a| a * scale), h * scale));
                    }
                }
            }
        }
        views
    }

    #[test]
    fn arguments_are_as_accurate_as_stated() {
        for k in -20_000..20_000 {
            let expected = PI as f64 * (f64::from(k) + 0.5) / 20_000.0;
            for size in [1e-100, 1.0, 1e100] {
                let ratio = f64::from(argument(Complex64::from_polar(size, expected))) / expected;
                assert!((ratio - 1.0).abs() < 3e-7, "{expected}: {ratio}");
            }
        }
    }

    #[test]
    fn the_solid_angle_is_that_of_four_arc_tangents() {
        // in the test the four arc tangents cancel: of each, double precision leaves 2e-16
        for (x, y, h) in views() {
            let expected = by_arc_tangents(x, y, h);
            let Some(seen) = SphericalRectangle::new(x, y, h) else {
                assert!(expected < 1.01 * f64::from(LEAST), "{x:?} {y:?} {h}");
                continue;
            };
            assert!(expected > 0.99 * f64::from(LEAST), "{x:?} {y:?} {h}");
            let found = f64::from(seen.solid_angle());
            assert!(
                (found - expected).abs() < 3e-7 * expected + 4e-15,
                "{x:?} {y:?} {h}: {found} {expected}"
            );
        }
        // half of all directions, from just under it; a cube's face, from its middle
        let seen = SphericalRectangle::new([-1.0, 2.0], [-1.0, 1.0], 1e-9).unwrap();
        assert!((seen.solid_angle() / TAU - 1.0).abs() < 1e-6);
        let seen = SphericalRectangle::new([-1.0, 1.0], [-1.0, 1.0], 1.0).unwrap();
        assert!((seen.solid_angle() / (TAU / 3.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_share_of_the_numbers_covers_its_share_of_the_solid_angle() {
        // up to x lies u of the whole solid angle, and along y the sine of elevation is even
        for (x, y, h) in views() {
            let whole = by_arc_tangents(x, y, h);
            let Some(seen) = SphericalRectangle::new(x, y, h) else {
                continue;
            };
            for (u, v) in [
                (0.0, 0.3),
                (0.1, 0.0),
                (0.5, 0.5),
                (0.77, 0.99),
                (0.999, 0.2),
            ] {
                let [px, py] = seen.point([u, v]);
                let share = by_arc_tangents([x[0], px], y, h) / whole;
                assert!(
                    (share - f64::from(u)).abs() < 2e-6,
                    "{x:?} {y:?} {h} {u}: {share}"
                );
                let across = px.hypot(h);
                let sine = |y: f64| y / across.hypot(y);
                let span = sine(y[1]) - sine(y[0]);
                let share = (sine(py) - sine(y[0])) / span;
                // here and there the sines lose what they agree in
                let bound = 1e-6 + 2e-15 / span;
                assert!(
                    (share - f64::from(v)).abs() < bound,
                    "{x:?} {y:?} {h} {v}: {share}"
                );
            }
        }
    }
}
