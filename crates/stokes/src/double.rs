//! Numbers of twice the precision: an unevaluated sum of two `f64`, about 106 bits.
//!
//! The covariant family of the paper ([`crate::covariant_mode`]) is a sum of large terms of both signs wherever its
//! shape matrix is thin; nothing else in this crate needs more than `f64`.
//!
//! Source: Joldes, Muller & Popescu, "Tight and rigorous error bounds for basic building blocks of double-word
//! arithmetic", ACM TOMS 44 (2017), Algorithms 1–3, 6, 12 and 18. Relative errors below 2^(−102), short of overflow
//! and of results so small that their tail underflows.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number `head + tail`, where `head` is that sum rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Double {
    pub(crate) head: f64,
    pub(crate) tail: f64,
}

impl Double {
    pub(crate) const ZERO: Self = Self {
        head: 0.0,
        tail: 0.0,
    };

    /// `a + b` exactly.
    #[inline]
    fn sum(a: f64, b: f64) -> Self {
        let head = a + b;
        let from_b = head - a;
        let tail = (a - (head - from_b)) + (b - from_b);
        Self { head, tail }
    }

    /// `a + b` exactly, for `|a| ≥ |b|` or `a = 0`.
    #[inline]
    fn ordered_sum(a: f64, b: f64) -> Self {
        let head = a + b;
        Self {
            head,
            tail: b - (head - a),
        }
    }

    /// `a · b` exactly.
    #[inline]
    pub(crate) fn product(a: f64, b: f64) -> Self {
        let head = a * b;
        Self {
            head,
            tail: a.mul_add(b, -head),
        }
    }

    /// `√a`, for `a` not negative.
    pub(crate) fn root(a: f64) -> Self {
        if a == 0.0 {
            return Self::ZERO;
        }
        let head = a.sqrt();
        Self::ordered_sum(head, (-head).mul_add(head, a) / (2.0 * head))
    }

    /// The number times `2^exponent`.
    pub(crate) fn scaled(self, exponent: i32) -> Self {
        Self {
            head: libm::scalbn(self.head, exponent),
            tail: libm::scalbn(self.tail, exponent),
        }
    }
}

impl From<f64> for Double {
    #[inline]
    fn from(head: f64) -> Self {
        Self { head, tail: 0.0 }
    }
}

impl Neg for Double {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self {
            head: -self.head,
            tail: -self.tail,
        }
    }
}

impl Add for Double {
    type Output = Self;

    /// Accurate also where the heads cancel.
    #[inline]
    fn add(self, other: Self) -> Self {
        let heads = Self::sum(self.head, other.head);
        let tails = Self::sum(self.tail, other.tail);
        let sum = Self::ordered_sum(heads.head, heads.tail + tails.head);
        Self::ordered_sum(sum.head, tails.tail + sum.tail)
    }
}

impl Sub for Double {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let heads = Self::product(self.head, other.head);
        let cross = self.head.mul_add(
            other.tail,
            self.tail.mul_add(other.head, self.tail * other.tail),
        );
        Self::ordered_sum(heads.head, heads.tail + cross)
    }
}

impl Div for Double {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let head = self.head / other.head;
        let rest = self - other * Self::from(head);
        Self::ordered_sum(head, rest.head / other.head)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_root_squares_to_its_number_in_twice_the_digits() {
        for a in [2.0, 3.0, 0.1, 255.0, 1e-30, 7e200] {
            let root = Double::root(a);
            let rest = root * root - a.into();
            assert!(rest.head.abs() <= 1e-31 * a, "{a}: {rest:?}");
        }
    }

    #[test]
    fn third_times_three_is_one_to_32_digits() {
        let third = Double::from(1.0) / 3.0.into();
        assert_eq!(third.head, 1.0 / 3.0);
        // 1/3 − fl(1/3) = 2^(−54)/3
        assert!((third.tail * 3.0 - 2f64.powi(-54)).abs() < 1e-31);
        assert!((third * 3.0.into() - 1.0.into()).head.abs() < 1e-32);
    }

    proptest! {
        #[test]
        fn what_is_added_can_be_taken_away(a in -1.0..1.0f64, b in -1e9..1e9f64, c in -1e-9..1e-9f64) {
            // three numbers whose sum needs more than 53 bits
            let sum = Double::from(a) + b.into() + c.into();
            let rest = sum - b.into() - a.into() - c.into();
            prop_assert!(rest.head.abs() <= 1e-30 * b.abs().max(1.0), "{rest:?}");
        }

        #[test]
        fn a_quotient_times_its_divisor_is_the_dividend(
            a in 0.1..10.0f64, b in 0.1..10.0f64, c in 0.1..10.0f64, d in 0.1..10.0f64,
        ) {
            let dividend = Double::product(a, b);
            let divisor = Double::product(c, d);
            let rest = dividend / divisor * divisor - dividend;
            prop_assert!(rest.head.abs() <= 8.0 * 2f64.powi(-102) * dividend.head);
        }

        #[test]
        fn the_cancelling_square_of_a_sum_is_right(a in 0.5..1.0f64, b in 1e-12..1e-8f64) {
            // (a + b)² − a² − b² = 2ab, where the left side cancels
            let sum = Double::from(a) + b.into();
            let left = sum * sum - Double::product(a, a) - Double::product(b, b);
            let right = Double::product(2.0 * a, b);
            prop_assert!((left - right).head.abs() <= 16.0 * 2f64.powi(-102));
        }
    }
}
