//! Numbers of twice the precision, for differences that cancel.

/// An unevaluated sum of two numbers, the second below half a unit in the last place of the first.
///
/// Source: Dekker, Numerische Mathematik 18, 224 (1971).
#[derive(Clone, Copy)]
pub(crate) struct Doubled(pub(crate) f64, pub(crate) f64);

impl Doubled {
    /// `a·b`, exactly.
    pub(crate) fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self(high, a.mul_add(b, -high))
    }

    /// `a + b`, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self(high, (a - (high - part)) + (b - part))
    }
}

impl std::ops::Add for Doubled {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.0, other.0), Self::sum(self.1, other.1));
        let first = Self::sum(high.0, high.1 + low.0);
        Self::sum(first.0, first.1 + low.1)
    }
}

impl std::ops::Mul for Doubled {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = Self::product(self.0, other.0);
        Self::sum(high.0, high.1 + (self.0 * other.1 + self.1 * other.0))
    }
}
