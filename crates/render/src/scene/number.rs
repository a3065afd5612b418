//! Numbers as scene files write them; each function's error says what was expected.

/// A finite number; blanks around it are allowed, anything else after it is not.
pub(super) fn float(text: &str) -> Result<f64, &'static str> {
    let value: f64 = text.trim().parse().map_err(|_| "a number")?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err("a finite number")
    }
}

/// A whole number of at most 64 bits.
pub(super) fn integer(text: &str) -> Result<i64, &'static str> {
    use std::num::IntErrorKind::{NegOverflow, PosOverflow};
    text.trim()
        .parse()
        .map_err(|failure: std::num::ParseIntError| match failure.kind() {
            PosOverflow => "an integer of at most 9223372036854775807",
            NegOverflow => "an integer of at least -9223372036854775808",
            _ => "an integer",
        })
}

/// `true` or `false` in any capitals.
pub(super) fn boolean(text: &str) -> Result<bool, &'static str> {
    match text.to_ascii_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => Err("'true' or 'false'"),
    }
}

/// The parts of a list that is separated by commas or blanks, or both.
pub(super) fn items(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace())
        .filter(|item| !item.is_empty())
}

/// A list of numbers.
pub(super) fn floats(text: &str) -> Result<Vec<f64>, &'static str> {
    items(text).map(float).collect()
}

/// Three numbers.
pub(super) fn triple(text: &str) -> Result<[f64; 3], &'static str> {
    floats(text)?
        .try_into()
        .map_err(|_| "three numbers, such as '0, 1, 0'")
}

/// Three numbers, or one that stands for all three.
pub(super) fn one_or_triple(text: &str) -> Result<[f64; 3], &'static str> {
    match floats(text)?[..] {
        [a] => Ok([a; 3]),
        [a, b, c] => Ok([a, b, c]),
        _ => Err("one or three numbers"),
    }
}

/// Wavelength in nm and value, `400:0.1, 700:0.9`, wavelengths rising.
pub(super) fn pairs(text: &str) -> Result<Vec<(f64, f64)>, &'static str> {
    let pairs = items(text)
        .map(|item| {
            let (nm, value) = item
                .split_once(':')
                .ok_or("a number or wavelength:value pairs, such as '400:0.1, 700:0.9'")?;
            Ok((float(nm)?, float(value)?))
        })
        .collect::<Result<Vec<_>, &'static str>>()?;
    check_pairs(&pairs)?;
    Ok(pairs)
}

/// Refuses tables that are no function of the wavelength.
pub(super) fn check_pairs(pairs: &[(f64, f64)]) -> Result<(), &'static str> {
    if pairs.len() < 2 {
        return Err("at least two wavelengths, or one number for all of them");
    }
    if pairs[0].0 <= 0.0 {
        return Err("positive wavelengths in nm");
    }
    if !pairs.is_sorted_by(|a, b| a.0 < b.0) {
        return Err("rising wavelengths");
    }
    Ok(())
}

/// `#rrggbb` as linear numbers in `0.0..=1.0`; the digits are sRGB code values, as on the web.
///
/// Source: IEC 61966-2-1, the inverse transfer function.
pub(super) fn hex_colour(text: &str) -> Result<[f64; 3], &'static str> {
    let digits = text.trim().strip_prefix('#').unwrap_or_default();
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err("a colour such as '#ff8000'");
    }
    let code = u32::from_str_radix(digits, 16).map_err(|_| "a colour such as '#ff8000'")?;
    let linear = |shift: u32| {
        let v = f64::from((code >> shift) & 0xff) / 255.0;
        if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    };
    Ok([linear(16), linear(8), linear(0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_nothing_follows_them() {
        for (text, value) in [("1", 1.0), (" -.5e1 ", -5.0), ("+2.", 2.0), ("1e-400", 0.0)] {
            assert_eq!(float(text), Ok(value));
        }
        for text in ["", " ", "1.0abc", "0x10", "1,5", "1 2", "1_0", "--1"] {
            assert_eq!(float(text), Err("a number"), "{text}");
        }
        for text in ["nan", "inf", "-infinity", "1e999"] {
            assert_eq!(float(text), Err("a finite number"), "{text}");
        }
    }

    #[test]
    fn integers_say_which_way_they_are_too_large() {
        assert_eq!(integer(" -12 "), Ok(-12));
        assert_eq!(integer("1.0"), Err("an integer"));
        assert!(integer("9223372036854775808").unwrap_err().contains("most"));
        assert!(integer("-1e3").is_err());
        assert!(
            integer("-99999999999999999999")
                .unwrap_err()
                .contains("least")
        );
    }

    #[test]
    fn lists_are_separated_by_commas_or_blanks() {
        assert_eq!(triple("1, 2 ,3"), Ok([1.0, 2.0, 3.0]));
        assert_eq!(triple(" 1\t2\n3 "), Ok([1.0, 2.0, 3.0]));
        assert_eq!(one_or_triple("2"), Ok([2.0; 3]));
        assert!(triple("1, 2").is_err());
        assert!(one_or_triple("").is_err());
    }

    #[test]
    fn tables_of_wavelengths_rise() {
        assert_eq!(pairs("400:.1 700:.9"), Ok(vec![(400.0, 0.1), (700.0, 0.9)]));
        assert_eq!(pairs("700:1, 400:1"), Err("rising wavelengths"));
        assert_eq!(pairs("400:1, 400:1"), Err("rising wavelengths"));
        assert_eq!(pairs("-1:1, 400:1"), Err("positive wavelengths in nm"));
        assert!(pairs("400:1").unwrap_err().starts_with("at least two"));
        assert!(pairs("400:1 500").is_err());
    }

    #[test]
    fn hex_colours_are_decoded_from_srgb() {
        assert_eq!(hex_colour("#ff0000"), Ok([1.0, 0.0, 0.0]));
        let grey = hex_colour("#808080").unwrap()[0];
        assert!((grey - 0.215_860_500_113_899).abs() < 1e-12, "{grey}");
        for text in ["#ff00", "ff0000", "#gg0000", "#ff00é", "#+f0000"] {
            assert!(hex_colour(text).is_err(), "{text}");
        }
    }
}
