//! Round numbers for limits, and short ones for legends.

/// The number rounded to two digits.
pub(super) fn two_digits(value: f64) -> f64 {
    let step = 10_f64.powf(value.log10().floor() - 1.0);
    let rounded = (value / step).round() * step;
    if rounded.is_finite() && rounded > 0.0 {
        rounded
    } else {
        value
    }
}

/// The next of 1, 2, 5 × 10ⁿ.
pub(super) fn round_up(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 0.0;
    }
    let decade = 10_f64.powf(value.log10().floor());
    // dividing by whole powers keeps 0.2 at 0.2
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * decade)
        .find(|&m| value <= m * (1.0 + 1e-6))
        .unwrap_or(10.0 * decade)
}

/// A number with three digits, as short as it goes.
pub(super) fn plain(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() || value.abs() >= 1e5 || value.abs() < 1e-5 {
        return format!("{value:.2e}").replace('-', "−");
    }
    let decimals = (2 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    text.replace('-', "−")
}

/// A share in percent; small ones are not rounded to nothing.
pub(super) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value > 0.0 && value < 0.01 {
        "under 0.01 %".to_owned()
    } else {
        format!("{} %", plain((value * 100.0).round() / 100.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (0.25, "0.25"),
            (1.0, "1"),
            (-0.5, "−0.5"),
            (22.5, "22.5"),
            (1234.5, "1234"),
            (0.0123456, "0.0123"),
            (1e-6, "1.00e−6"),
        ];
        for (value, text) in cases {
            assert_eq!(plain(value), text);
        }
        assert_eq!(
            (percent(0.0), percent(1e-6), percent(0.12345)),
            ("0 %".into(), "under 0.01 %".into(), "12.3 %".into())
        );
    }

    #[test]
    fn limits_are_round() {
        assert_eq!(
            [0.011, 0.02, 0.3, 0.99, 1.0].map(round_up),
            [0.02, 0.02, 0.5, 1.0, 1.0]
        );
        assert_eq!(round_up(0.0), 0.0);
    }
}
