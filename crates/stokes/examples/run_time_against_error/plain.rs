//! The yardsticks: the same sums and products as loops that anybody would write first, with the order known to the
//! compiler.

/// `√(2/(n+1))` and `√(n/(n+1))`.
pub(crate) fn factors<T: From<f32> + Copy, const SIZE: usize>(
    narrow: impl Fn(f64) -> T,
) -> [[T; 2]; SIZE] {
    std::array::from_fn(|n| {
        let next = (n + 1) as f64;
        [
            narrow((2.0 / next).sqrt()),
            narrow((n as f64 / next).sqrt()),
        ]
    })
}

macro_rules! scalar {
    ($hermite:ident, $all_modes:ident, $sum:ident, $type:ty) => {
        #[inline(always)]
        fn $hermite<const SIZE: usize>(t: $type, factors: &[[$type; 2]; SIZE]) -> [$type; SIZE] {
            let mut h = [0.0; SIZE];
            h[0] = 0.751_125_544_464_942_5 * (-0.5 * t * t).exp();
            if SIZE > 1 {
                h[1] = factors[0][0] * t * h[0];
            }
            for n in 2..SIZE {
                h[n] = factors[n - 1][0] * t * h[n - 1] - factors[n - 1][1] * h[n - 2];
            }
            h
        }

        /// All modes below total order SIZE at one point.
        #[inline(never)]
        pub(crate) fn $all_modes<const SIZE: usize>(
            y: [$type; 2],
            factors: &[[$type; 2]; SIZE],
            modes: &mut [$type],
        ) {
            let (h1, h2) = ($hermite(y[0], factors), $hermite(y[1], factors));
            let mut i = 0;
            for n in 0..SIZE {
                for b in 0..n + 1 {
                    modes[i] = h1[n - b] * h2[b];
                    i += 1;
                }
            }
        }

        /// The sum with complex coefficients at one point.
        #[inline(never)]
        pub(crate) fn $sum<const SIZE: usize>(
            y: [$type; 2],
            factors: &[[$type; 2]; SIZE],
            coefficients: &[[$type; 2]],
        ) -> [$type; 2] {
            let (h1, h2) = ($hermite(y[0], factors), $hermite(y[1], factors));
            let (mut re, mut im, mut i) = (0.0, 0.0, 0);
            for n in 0..SIZE {
                for b in 0..n + 1 {
                    let mode = h1[n - b] * h2[b];
                    re += coefficients[i][0] * mode;
                    im += coefficients[i][1] * mode;
                    i += 1;
                }
            }
            [re, im]
        }
    };
}

scalar!(hermite_f32, all_modes_f32, sum_f32, f32);
scalar!(hermite_f64, all_modes_f64, sum_f64, f64);

type Eight = [f32; 8];

/// `e^x` for −87 < x ≤ 0, the polynomial of Cephes' `expf`.
#[inline(always)]
fn exp_of_eight(x: Eight) -> Eight {
    let mut e = [0.0; 8];
    for l in 0..8 {
        let shifted = x[l] * std::f32::consts::LOG2_E + 12_582_912.0;
        let m = shifted - 12_582_912.0;
        let r = (x[l] - m * 0.693_359_375) + m * 2.121_944_4e-4;
        let mut p = 1.987_569_15e-4;
        p = p * r + 1.398_199_95e-3;
        p = p * r + 8.333_451_9e-3;
        p = p * r + 4.166_579_6e-2;
        p = p * r + 1.666_666_55e-1;
        p = p * r + 5.000_000_1e-1;
        let power = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
        e[l] = power * (p * r * r + r + 1.0);
    }
    e
}

#[inline(always)]
fn hermite_of_eight<const SIZE: usize>(t: Eight, factors: &[[f32; 2]; SIZE]) -> [Eight; SIZE] {
    let mut h = [[0.0; 8]; SIZE];
    let mut x = [0.0; 8];
    for l in 0..8 {
        x[l] = -0.5 * t[l] * t[l];
    }
    let e = exp_of_eight(x);
    for l in 0..8 {
        h[0][l] = 0.751_125_54 * e[l];
    }
    if SIZE > 1 {
        for l in 0..8 {
            h[1][l] = factors[0][0] * t[l] * h[0][l];
        }
    }
    for n in 2..SIZE {
        for l in 0..8 {
            h[n][l] = factors[n - 1][0] * t[l] * h[n - 1][l] - factors[n - 1][1] * h[n - 2][l];
        }
    }
    h
}

/// All modes below total order SIZE at eight points, coordinates and modes as arrays of lanes.
#[inline(never)]
pub(crate) fn all_modes_of_eight<const SIZE: usize>(
    y: [Eight; 2],
    factors: &[[f32; 2]; SIZE],
    modes: &mut [Eight],
) {
    let (h1, h2) = (
        hermite_of_eight(y[0], factors),
        hermite_of_eight(y[1], factors),
    );
    let mut i = 0;
    for n in 0..SIZE {
        for b in 0..n + 1 {
            for l in 0..8 {
                modes[i][l] = h1[n - b][l] * h2[b][l];
            }
            i += 1;
        }
    }
}

/// The sum with complex coefficients at eight points.
#[inline(never)]
pub(crate) fn sum_of_eight<const SIZE: usize>(
    y: [Eight; 2],
    factors: &[[f32; 2]; SIZE],
    coefficients: &[[f32; 2]],
) -> [Eight; 2] {
    let (h1, h2) = (
        hermite_of_eight(y[0], factors),
        hermite_of_eight(y[1], factors),
    );
    let mut sum = [[0.0; 8]; 2];
    let mut i = 0;
    for n in 0..SIZE {
        for b in 0..n + 1 {
            for l in 0..8 {
                let mode = h1[n - b][l] * h2[b][l];
                sum[0][l] += coefficients[i][0] * mode;
                sum[1][l] += coefficients[i][1] * mode;
            }
            i += 1;
        }
    }
    sum
}
