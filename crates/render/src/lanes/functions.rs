//! Exponential, logarithm and circular functions, the same bits in one lane and in eight.
//!
//! Source of the approximations: Moshier, Cephes Mathematical Library, single precision.

use super::{Bits, Real};

/// A polynomial, highest power first.
#[inline(always)]
pub fn polynomial<R: Real>(x: R, coefficients: &[f32]) -> R {
    let mut sum = R::zero();
    for (k, c) in coefficients.iter().enumerate() {
        sum = if k == 0 {
            R::splat(*c)
        } else {
            sum * x + R::splat(*c)
        };
    }
    sum
}

/// The exponential, relative error below 2e-7; 0 below −87, and held above 88.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    let tiny = x.lt(R::splat(-87.0));
    let x = x.clamp(-87.0, 88.0);
    let n = (x * R::splat(std::f32::consts::LOG2_E)).round();
    // ln 2 in two parts, of which the first has few digits
    let r = x - n * R::splat(0.693_359_4) - n * R::splat(-2.121_944_4e-4);
    let p = polynomial(
        r,
        &[
            1.987_569_1e-4,
            1.398_199_9e-3,
            8.333_452e-3,
            4.166_579_6e-2,
            1.666_666_6e-1,
            5.000_000_1e-1,
        ],
    );
    let p = p * r * r + r + R::one();
    let scale = R::of_bits((n.to_int() + R::B::splat(127)).shl::<23>());
    R::select(tiny, R::zero(), p * scale)
}

/// The logarithm of normal positive numbers, relative error below 2e-7 away from 1, absolute below 1e-7 next to it.
#[inline(always)]
pub fn ln<R: Real>(x: R) -> R {
    let bits = x.bits();
    // times 2ᵉ, a number from ½ to 1; a bias that keeps the integer positive
    let e = R::of_int(bits.shr::<23>()) - R::splat(126.0);
    let m = R::of_bits((bits & R::B::splat(0x007f_ffff)) | R::B::splat(0x3f00_0000));
    let low = m.lt(R::splat(std::f32::consts::FRAC_1_SQRT_2));
    let e = R::select(low, e - R::one(), e);
    let m = R::select(low, m + m, m) - R::one();
    let z = m * m;
    let p = polynomial(
        m,
        &[
            7.037_683_6e-2,
            -1.151_461e-1,
            1.167_699_9e-1,
            -1.242_014_1e-1,
            1.424_932_3e-1,
            -1.666_805_8e-1,
            2.000_071_5e-1,
            -2.499_999_4e-1,
            3.333_333_1e-1,
        ],
    );
    let y = p * m * z + e * R::splat(-2.121_944_4e-4) - z * R::splat(0.5);
    m + y + e * R::splat(0.693_359_4)
}

/// Sine and cosine of 2πu for u in [0, 1], absolute error below 2e-7.
#[inline(always)]
pub fn sin_cos_turns<R: Real>(u: R) -> (R, R) {
    let turns = u * R::splat(4.0);
    let quarter = turns.round();
    let a = (turns - quarter) * R::splat(std::f32::consts::FRAC_PI_2);
    let z = a * a;
    let s = polynomial(z, &[-1.951_529_6e-4, 8.332_161e-3, -1.666_665_5e-1]) * z * a + a;
    let c = polynomial(z, &[2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2]) * z * z
        - z * R::splat(0.5)
        + R::one();
    let n = quarter.to_int();
    let odd = R::same(n & R::B::splat(1), R::B::splat(1));
    let (sin, cos) = (R::select(odd, c, s), R::select(odd, s, c));
    // the second bit of n, and of n + 1, is the sign
    let two = R::B::splat(2);
    let sign_of_sin = (n & two).shl::<30>();
    let sign_of_cos = ((n + R::B::splat(1)) & two).shl::<30>();
    (
        R::of_bits(sin.bits() ^ sign_of_sin),
        R::of_bits(cos.bits() ^ sign_of_cos),
    )
}

/// The angle of (x, y), absolute error below 3e-7; 0 for (0, 0).
#[inline(always)]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    let (ay, ax) = (y.abs(), x.abs());
    let steep = ay.gt(ax);
    let (low, high) = (R::select(steep, ax, ay), R::select(steep, ay, ax));
    let t = R::select(high.gt(R::zero()), low / high, R::zero());
    // beyond tan π/8 the angle from π/4
    let far = t.gt(R::splat(0.414_213_57));
    let t = R::select(far, (t - R::one()) / (t + R::one()), t);
    let z = t * t;
    let p = polynomial(
        z,
        &[
            8.053_744_6e-2,
            -1.387_768_6e-1,
            1.997_771_1e-1,
            -3.333_294_9e-1,
        ],
    ) * z
        * t
        + t;
    let quarter = R::splat(std::f32::consts::FRAC_PI_4);
    let p = R::select(far, p + quarter, p);
    let p = R::select(steep, R::splat(std::f32::consts::FRAC_PI_2) - p, p);
    let p = R::select(x.lt(R::zero()), R::splat(std::f32::consts::PI) - p, p);
    p.copysign(y)
}
