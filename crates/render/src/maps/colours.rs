//! Colours of numbers and angles, and the tone curve.

use super::drawing::Rgb;

/// Whose colours tell the senses of rotation; the field uses both, so each legend says which.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum HandednessColours {
    /// Right blue, left yellow (Mitsuba, Wilkie and Weidlich 2010).
    #[default]
    Mitsuba,
    /// Right yellow, left blue (polanalyser, mitransient).
    Polanalyser,
}

const BLUE: Rgb = [58, 138, 255];
const YELLOW: Rgb = [255, 208, 20];

impl HandednessColours {
    /// Colour of S3 > 0, clockwise for an observer who faces the source.
    pub(super) fn right(self) -> Rgb {
        match self {
            Self::Mitsuba => BLUE,
            Self::Polanalyser => YELLOW,
        }
    }

    /// Colour of S3 < 0.
    pub(super) fn left(self) -> Rgb {
        match self {
            Self::Mitsuba => YELLOW,
            Self::Polanalyser => BLUE,
        }
    }

    /// What the legend says.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mitsuba => "mitsuba: right blue, left yellow",
            Self::Polanalyser => "polanalyser: right yellow, left blue",
        }
    }
}

/// From 0 to 1: viridis.
pub(super) fn sequential(t: f64) -> Rgb {
    colour(colorous::VIRIDIS.eval_continuous(unit(t)))
}

/// From 0 (red) over white to 1 (blue), as polanalyser and matplotlib's RdBu.
pub(super) fn diverging(t: f64) -> Rgb {
    colour(colorous::RED_BLUE.eval_continuous(unit(t)))
}

/// From 0 (left-handed) over near-black to 1 (right-handed).
pub(super) fn handed(t: f64, colours: HandednessColours) -> Rgb {
    let signed = 2.0 * unit(t) - 1.0;
    let end = if signed < 0.0 {
        colours.left()
    } else {
        colours.right()
    };
    mix([22, 22, 26], end, signed.abs().powf(0.8))
}

/// An angle of linear polarization in radians: hue, once around in π. Red 0°, green 60°, blue 120°.
pub(super) fn hue(angle: f64, value: f64) -> Rgb {
    let sixth = (angle / std::f64::consts::PI).rem_euclid(1.0) * 6.0;
    let channel = |shift: f64| {
        let k = (shift + sixth).rem_euclid(6.0);
        1.0 - k.min(4.0 - k).clamp(0.0, 1.0)
    };
    [5.0, 3.0, 1.0].map(|shift| (255.0 * unit(value) * channel(shift)).round() as u8)
}

/// Type of polarization: cyan where linear (0), yellow where circular (1), times the degree.
pub(super) fn kind(circular: f64, degree: f64) -> Rgb {
    mix(
        [0; 3],
        mix([0, 255, 255], [255, 255, 0], unit(circular)),
        unit(degree),
    )
}

/// A linear intensity of 0 to 1 as an sRGB byte (IEC 61966-2-1).
pub(super) fn srgb(linear: f64) -> u8 {
    let v = unit(linear);
    let coded = if v <= 0.0031308 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * coded).round() as u8
}

/// The mixture of two colours as displayed, `t` of the second.
pub(super) fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    std::array::from_fn(|i| {
        (f64::from(a[i]) + (f64::from(b[i]) - f64::from(a[i])) * t).round() as u8
    })
}

/// Diagonal stripes: no number here. `(x, y)` in pixels of the page.
pub(super) fn stripes(x: usize, y: usize, period: usize) -> Rgb {
    if ((x + y) / period.max(1)).is_multiple_of(2) {
        [196, 199, 204]
    } else {
        [222, 224, 228]
    }
}

/// The number itself in 0 to 1; NaN is 0.
fn unit(t: f64) -> f64 {
    if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
}

fn colour(c: colorous::Color) -> Rgb {
    [c.r, c.g, c.b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn hue_is_red_green_blue_at_0_60_120_degrees_and_cyclic() {
        assert_eq!(hue(0.0, 1.0), [255, 0, 0]);
        assert_eq!(hue(PI / 3.0, 1.0), [0, 255, 0]);
        assert_eq!(hue(2.0 * PI / 3.0, 1.0), [0, 0, 255]);
        assert_eq!(hue(PI, 1.0), hue(0.0, 1.0));
        assert_eq!(hue(PI / 2.0, 0.0), [0, 0, 0]);
    }

    #[test]
    fn colours_of_handedness_change_sides() {
        assert_eq!(handed(1.0, HandednessColours::Mitsuba), BLUE);
        assert_eq!(handed(1.0, HandednessColours::Polanalyser), YELLOW);
        assert_eq!(handed(0.0, HandednessColours::Mitsuba), YELLOW);
    }

    #[test]
    fn numbers_beyond_the_scale_have_the_colours_of_its_ends() {
        assert_eq!(sequential(7.0), sequential(1.0));
        assert_eq!(diverging(-1.0), diverging(0.0));
        assert_eq!(sequential(f64::NAN), sequential(0.0));
        assert_eq!((srgb(0.0), srgb(1.0), srgb(0.214)), (0, 255, 127));
    }

    #[test]
    fn linear_light_is_cyan_and_circular_yellow() {
        assert_eq!(kind(0.0, 1.0), [0, 255, 255]);
        assert_eq!(kind(1.0, 1.0), [255, 255, 0]);
        assert_eq!(kind(0.5, 0.0), [0, 0, 0]);
    }
}
