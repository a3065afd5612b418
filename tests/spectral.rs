//! Claim: one wavelength, bands and colours are the same light, looked at in three ways.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use brewster_tests::{SIGMAS, Shot, assert_stokes, film_scene, mean, pixel, repository, scene};
use render::film::SpectralMode;
use render::image::StokesImage;

fn constant(radiance: &str) -> String {
    format!("<emitter type='constant'><spectrum name='radiance' {radiance}/></emitter>")
}

/// Stokes vector in one colour, and its standard errors.
type Seen<'a> = &'a dyn Fn(&StokesImage, usize) -> ([f64; 4], [f64; 4]);

/// A scene of nothing but light.
fn light(radiance: &str) -> String {
    scene(
        2,
        "origin='0, 0, 1' target='0, 0, 0' up='0, 1, 0'",
        10.0,
        &constant(radiance),
    )
}

/// CIE 1931 colour matching functions at 360, 361, … 830 nm, from the table in `data/cie`.
fn colour_matching() -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(repository().join("data/cie/cie1931_2deg_d65.csv")).unwrap();
    let rows = text.lines().skip(2).map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        [numbers[1], numbers[2], numbers[3]]
    });
    let rows: Vec<[f64; 3]> = rows.collect();
    assert_eq!(rows.len(), 471);
    rows
}

/// Linear sRGB of XYZ.
///
/// Source: the matrix of IEC 61966-2-1, primaries of Rec. 709 and D65, with six digits.
fn srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240479 * x - 1.537150 * y - 0.498535 * z,
        -0.969256 * x + 1.875991 * y + 0.041556 * z,
        0.055648 * x - 0.204043 * y + 1.057311 * z,
    ]
}

/// A unit spectrum has Y = 1.0010, as Mitsuba's tables have it.
const UNIT_LUMINANCE: f64 = 1.0010;

/// Linear sRGB of a spectrum by the trapezoidal rule over 1 nm.
fn integrate(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let table = colour_matching();
    let luminance: f64 = table.iter().map(|row| row[1]).sum();
    let mut sum = [0.0; 3];
    for (i, row) in table.iter().enumerate() {
        let weight = if i == 0 || i == 470 { 0.5 } else { 1.0 };
        let value = spectrum(360.0 + i as f64);
        sum = [0, 1, 2].map(|c| sum[c] + weight * value * row[c] * UNIT_LUMINANCE / luminance);
    }
    srgb(sum)
}

#[test]
fn a_unit_emitter_has_a_luminance_of_1_0010() {
    let expected = integrate(|_| 1.0);
    let image = Shot {
        mode: SpectralMode::Rgb,
        ..Shot::new(200_000)
    }
    .of_text(&light("value='1'"));
    let mut luminance = 0.0;
    for (colour, weight) in [0.2126, 0.7152, 0.0722].into_iter().enumerate() {
        let (s, error) = mean(&image, colour);
        // Y is stated with four decimals
        assert_stokes(
            &format!("colour {colour}"),
            (s, error),
            [expected[colour], 0.0, 0.0, 0.0],
            2e-4,
        );
        luminance += weight * s[0];
    }
    // the noise of the three colours together is below theirs added
    let noise: f64 = (0..3).map(|c| mean(&image, c).1[0]).sum();
    assert!(
        (luminance - UNIT_LUMINANCE).abs() < SIGMAS * noise + 2e-4,
        "{luminance}"
    );
    assert!(
        (expected[0] - 1.205).abs() < 2e-3 && (expected[1] - 0.949).abs() < 2e-3,
        "{expected:?}"
    );
}

#[test]
fn a_tabulated_spectrum_is_linear_between_its_wavelengths_and_zero_outside() {
    let table = "value='400:0.1, 500:0.5, 700:0.9'";
    for (wavelength, expected) in [
        (390.0, 0.0),
        (400.0, 0.1),
        (450.0, 0.3),
        (500.0, 0.5),
        (650.0, 0.8),
        (699.0, 0.898),
        (701.0, 0.0),
        (1600.0, 0.0),
    ] {
        let shot = Shot {
            mode: SpectralMode::Single(wavelength),
            ..Shot::new(2)
        };
        let found = pixel(&shot.of_text(&light(table)), 0, 0, 0);
        assert_stokes(
            &format!("{wavelength} nm"),
            found,
            [expected, 0.0, 0.0, 0.0],
            1e-6,
        );
    }
}

#[test]
fn a_band_holds_the_mean_of_its_spectrum() {
    let shot = Shot {
        mode: SpectralMode::Bands {
            from: 380.0,
            to: 480.0,
            count: 5,
        },
        ..Shot::new(20_000)
    };
    let image = shot.of_text(&light("value='400:0, 440:0.4, 480:0'"));
    assert_eq!(image.colour.count(), 5);
    for (band, expected) in [0.0, 0.1, 0.3, 0.3, 0.1].into_iter().enumerate() {
        assert_stokes(
            &format!("band {band}"),
            pixel(&image, 0, 0, band),
            [expected, 0.0, 0.0, 0.0],
            1e-6,
        );
    }
}

#[test]
fn plain_numbers_mean_the_same_in_every_band() {
    let shot = |mode| Shot {
        mode,
        ..Shot::new(2)
    };
    let bands = shot(SpectralMode::Bands {
        from: 300.0,
        to: 2000.0,
        count: 7,
    })
    .of_text(&light("value='0.7'"));
    let green = shot(SpectralMode::Single(550.0)).of_text(&light("value='0.7'"));
    for band in 0..7 {
        assert_eq!(bands.stokes_at(0, 0, band), green.stokes_at(0, 0, 0));
    }
}

/// Coloured light on coloured metal and plastic.
fn coloured() -> String {
    let content = format!(
        "{}
        <shape type='rectangle'><transform name='to_world'><scale value='4'/><rotate x='1' angle='-60'/><translate y='-1'/></transform>
            <bsdf type='diffuse'><spectrum name='reflectance' value='360:0.05, 500:0.1, 560:0.2, 600:0.7, 830:0.8'/></bsdf></shape>
        <shape type='sphere'><bsdf type='conductor'>
            <spectrum name='eta' value='360:1.7, 450:1.5, 500:0.86, 550:0.43, 600:0.25, 830:0.19'/>
            <spectrum name='k' value='360:1.9, 450:1.88, 500:1.85, 550:2.46, 600:2.99, 830:5'/></bsdf></shape>",
        constant("value='360:0.2, 450:1, 550:0.4, 650:0.9, 830:0.1'")
    );
    film_scene(
        6,
        "origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'",
        40.0,
        [12, 12],
        &content,
    )
}

#[test]
fn fine_bands_integrated_over_the_colour_matching_functions_are_the_colours() {
    const BANDS: usize = 94;
    let render = |mode, spp| {
        Shot {
            mode,
            ..Shot::new(spp)
        }
        .of_text(&coloured())
    };
    let bands = render(
        SpectralMode::Bands {
            from: 360.0,
            to: 830.0,
            count: BANDS,
        },
        256,
    );
    let rgb = render(SpectralMode::Rgb, 4096);
    // colour matching functions averaged over each band of 5 nm
    let table = colour_matching();
    let luminance: f64 = table.iter().map(|row| row[1]).sum();
    let weights: Vec<[f64; 3]> = (0..BANDS)
        .map(|band| {
            let end = |i: usize| if i == 0 || i == 5 { 0.5 } else { 1.0 };
            let xyz = [0, 1, 2].map(|c| {
                (0..=5)
                    .map(|i| end(i) * table[5 * band + i][c])
                    .sum::<f64>()
                    / luminance
            });
            srgb(xyz.map(|v| v * UNIT_LUMINANCE))
        })
        .collect();
    let check = |what: &str, seen: Seen<'_>| {
        for colour in 0..3 {
            let (mut sum, mut error) = ([0.0; 4], [0.0; 4]);
            for (band, weight) in weights.iter().enumerate() {
                let (s, e) = seen(&bands, band);
                for k in 0..4 {
                    sum[k] += weight[colour] * s[k];
                    // the bands of a sample share their random numbers: errors add up at worst
                    error[k] += (weight[colour] * e[k]).abs();
                }
            }
            let (s, e) = seen(&rgb, colour);
            let both = [0, 1, 2, 3].map(|k| error[k].hypot(e[k]));
            // within 5 nm spectra and weights bend together: 2e-4 of the light
            assert_stokes(
                &format!("{what}, colour {colour}"),
                (s, both),
                sum,
                2e-4 * sum[0].abs() + 1e-5,
            );
        }
    };
    check("whole image", &mean);
    for y in 0..12 {
        for x in 0..12 {
            check(&format!("pixel {x}, {y}"), &|image, colour| {
                pixel(image, x, y, colour)
            });
        }
    }
}

#[test]
fn a_narrow_band_is_its_wavelength() {
    let render = |mode| {
        Shot {
            mode,
            ..Shot::new(64)
        }
        .of_text(&coloured())
    };
    let band = render(SpectralMode::Bands {
        from: 609.99,
        to: 610.01,
        count: 1,
    });
    let single = render(SpectralMode::Single(610.0));
    for (a, b) in band.stokes.iter().zip(&single.stokes) {
        // the same random numbers: the spectra differ by 1e-4 of their slope over 0.01 nm
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    assert!(
        single.stokes.chunks(4).any(|s| s[1].abs() > 0.01),
        "the metal polarizes"
    );
}
