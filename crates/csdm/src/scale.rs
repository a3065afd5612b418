//! Powers of two by which numbers are brought near 1, so that squares neither overflow nor vanish.

/// The power of two next below `size`, to within a factor of 2; between 2⁻¹⁰²² and 2¹⁰²², and 1 for 0.
///
/// Dividing by it is exact but for results below the normal range.
pub(crate) fn power_of_two(size: f64) -> f64 {
    if size > 0.0 {
        size.log2().floor().clamp(-1022.0, 1022.0).exp2()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_size_come_near_one_and_back() {
        for size in [f64::MIN_POSITIVE, 1e-200, 0.3, 1.0, 7.5, 1e200, f64::MAX] {
            let scale = power_of_two(size);
            assert!((0.9..16.0).contains(&(size / scale)), "{size}");
            assert_eq!(size / scale * scale, size);
        }
        assert_eq!(power_of_two(0.0), 1.0);
    }
}
