//! Tests of thin films: Airy's formula, power, reciprocity, messages.

use std::f64::consts::TAU;

use super::super::testing::{broken_reciprocity, common_axis, direction, matrix, read, vertex};
use super::*;

fn layered(parameters: &str) -> Layered {
    read("layered", parameters, Layered::read).unwrap_or_else(|e| panic!("{e}"))
}

const SOAP: &str = "<string name='thickness' value='320nm'/><float name='ior' value='1.33'/><float name='ext_ior' value='1'/>";
const OXIDE: &str = "<string name='thickness' value='150nm'/><string name='ior' value='2.3'/>\
    <string name='int_ior' value='2.9-2.87i'/><float name='ext_ior' value='1'/>";
const COATING: &str = "<string name='thickness' value='100nm, 60nm'/><string name='ior' value='1.38, 2.1'/>\
    <float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>";

/// r_s, r_p of a film by Airy's sum, `(r₁ + r₂e^{−2iβ})/(1 + r₁r₂e^{−2iβ})`.
///
/// Source: Born & Wolf, 7th ed., section 1.6.4, Eq. (57), in `exp(+iωt)`; r_p by the electric field with
/// r_p = −r_s at normal incidence.
fn airy(film: Complex64, behind: Complex64, thickness: f64, angle: f64) -> [Complex64; 2] {
    let sine = Complex64::from(angle.sin());
    let cosine = |n: Complex64| (1.0 - (sine / n).powi(2)).sqrt();
    let media = [Complex64::ONE, film, behind];
    let face = |a: Complex64, b: Complex64| {
        let (ca, cb) = (cosine(a), cosine(b));
        [
            (a * ca - b * cb) / (a * ca + b * cb),
            (b * ca - a * cb) / (b * ca + a * cb),
        ]
    };
    let [front, back] = [face(media[0], media[1]), face(media[1], media[2])];
    let beta = TAU * thickness / 550e-9 * film * cosine(film);
    let turn = (-2.0 * Complex64::I * beta).exp();
    [0, 1].map(|p| (front[p] + back[p] * turn) / (1.0 + front[p] * back[p] * turn))
}

#[test]
fn films_reflect_as_airy_says() {
    for (parameters, film, behind, nm) in [
        (SOAP, Complex64::from(1.33), Complex64::ONE, 320.0),
        (
            OXIDE,
            Complex64::from(2.3),
            Complex64::new(2.9, -2.87),
            150.0,
        ),
    ] {
        let matter = layered(parameters);
        for degrees in [0.0, 20.0, 57.0, 85.0] {
            let [s, p] = airy(film, behind, nm * 1e-9, f64::to_radians(degrees));
            let o = direction(degrees, 0.4);
            let i = mirror(o, Vec3A::Z);
            let axis = if degrees == 0.0 {
                Vec3A::X
            } else {
                common_axis(o, i)
            };
            let m = matrix(&matter, (o, axis), (i, axis), Part::Discrete(0), 550.0);
            let mean = 0.5 * (s.norm_sqr() + p.norm_sqr());
            let difference = 0.5 * (s.norm_sqr() - p.norm_sqr());
            let product = s * p.conj();
            // S2 = 2 Re E_s E_p*, S3 = −2 Im E_s E_p*
            for (row, column, expected) in [
                (0, 0, mean),
                (0, 1, difference),
                (2, 2, product.re),
                (2, 3, product.im),
                (3, 2, -product.im),
                (3, 3, product.re),
            ] {
                // the direction in single precision turns the frame of near-normal light by 1e-6
                assert!(
                    (m[(row, column)] - expected).abs() < 2e-6,
                    "{parameters} {degrees}: M{row}{column} = {}, expected {expected}",
                    m[(row, column)]
                );
            }
        }
    }
}

/// Share of the power of unpolarized light that goes on, from the side of `i`.
fn powers(matter: &Layered, i: Vec3A) -> [f64; 2] {
    let o = mirror(i, Vec3A::Z);
    let axis = common_axis(o, i);
    let reflected = matrix(matter, (o, axis), (i, axis), Part::Discrete(0), 550.0)[(0, 0)];
    // light that arrives along −i leaves where light toward i would come from
    let passed = matter.refracted(i, 550.0).map_or(0.0, |(o, eta)| {
        let axis = common_axis(o, i);
        let m = matrix(matter, (o, axis), (i, axis), Part::Discrete(1), 550.0);
        // radiance grows by (n_o/n_i)²: without it, power
        m[(0, 0)] * f64::from(eta * eta).recip()
    });
    [reflected, passed]
}

#[test]
fn clear_films_keep_all_power_and_absorbing_ones_lose_some() {
    for parameters in [SOAP, COATING] {
        let matter = layered(parameters);
        for degrees in [1.0, 30.0, 60.0, 80.0, 100.0, 120.0, 150.0] {
            let [r, t] = powers(&matter, direction(degrees, 1.1));
            assert!(
                (r + t - 1.0).abs() < 2e-6,
                "{parameters} {degrees}: {r} + {t}"
            );
        }
    }
    let [r, t] = powers(&layered(OXIDE), direction(40.0, 0.0));
    assert!(r < 0.9 && t == 0.0);
    let gold = layered(
        "<string name='thickness' value='20nm'/><string name='ior' value='Au'/><float name='ext_ior' value='1'/>",
    );
    let [r, t] = powers(&gold, direction(40.0, 0.0));
    assert!(r > 0.1 && t > 0.1 && r + t < 0.95, "{r} + {t}");
}

#[test]
fn films_are_reciprocal() {
    for (parameters, n) in [(SOAP, 1.0), (COATING, 1.5)] {
        let matter = layered(parameters);
        for degrees in [10.0, 50.0, 75.0] {
            let o = direction(degrees, 0.3);
            let (i, eta) = matter.refracted(o, 550.0).unwrap();
            assert!((f64::from(eta) - n).abs() < 1e-6);
            let off = broken_reciprocity(&matter, (o, i), Part::Discrete(1), 550.0, n * n);
            // Snell's law in single precision
            assert!(off < 5e-6, "{parameters} {degrees}: {off}");
            let mirrored = (o, mirror(o, Vec3A::Z));
            let off = broken_reciprocity(&matter, mirrored, Part::Discrete(0), 550.0, 1.0);
            assert!(off < 2e-6, "{parameters} {degrees}: {off}");
        }
    }
}

#[test]
fn ways_are_drawn_with_their_probability() {
    let wavelengths = [450.0, 550.0, 650.0, 750.0];
    for parameters in [SOAP, COATING, OXIDE] {
        let matter = layered(parameters);
        for degrees in [5.0, 70.0, 150.0] {
            let at = vertex(direction(degrees, 2.0));
            let mut counts = [(0, 0.0); 2];
            const N: usize = 20_000;
            for step in 0..N {
                let u = [(step as f32 + 0.5) / N as f32, 0.5, 0.5];
                if let Some(d) = matter.sample(&at, &wavelengths, u) {
                    let way = usize::from(d.direction.z * at.o.z < 0.0);
                    counts[way].0 += 1;
                    counts[way].1 = d.density;
                }
            }
            let one_sided = matter.is_opaque() && degrees > 90.0;
            let total: usize = counts.iter().map(|c| c.0).sum();
            assert_eq!(total, if one_sided { 0 } else { N });
            for (share, density) in counts {
                // an even grid of N numbers
                assert!(
                    (share as f32 / N as f32 - density).abs() < 2.0 / N as f32,
                    "{parameters}"
                );
            }
        }
    }
}

#[test]
fn free_films_are_drawn_more_often_than_they_reflect() {
    let matter = layered(SOAP);
    let at = vertex(direction(20.0, 0.0));
    let [r, t] = powers(&matter, at.o);
    let share = f64::from(matter.reflected_share(&at, &[550.0]));
    assert!((share - r.sqrt() / (r.sqrt() + t.sqrt())).abs() < 1e-6);
    assert!(r < 0.08 && share > 2.5 * r, "{r} {share}");
}

#[test]
fn light_inside_is_reflected_totally() {
    let matter = layered(COATING);
    let [r, t] = powers(&matter, direction(135.0, 0.0));
    assert!((r - 1.0).abs() < 1e-6 && t == 0.0);
    let departure = matter
        .sample(&vertex(direction(135.0, 0.0)), &[550.0], [0.99, 0.0, 0.0])
        .unwrap();
    assert!(departure.density == 1.0 && departure.part == Part::Discrete(0));
}

#[test]
fn a_film_that_thins_out_turns_black() {
    // half a wave is lost at one of the two faces
    let o = direction(5.0, 0.0);
    let i = mirror(o, Vec3A::Z);
    let axis = common_axis(o, i);
    // seen at the origin, y above the middle of the wedge
    let reflected = |y: f64| {
        let matter = layered(&format!(
            "<string name='thickness' value='400nm'/><float name='ior' value='1.33'/><vector name='wedge' value='0 -1 0'/>
             <point name='wedge_origin' value='0 {} 0'/>",
            -y
        ));
        matrix(&matter, (o, axis), (i, axis), Part::Discrete(0), 550.0)[(0, 0)]
    };
    assert!(reflected(1.0).abs() < 1e-12);
    // the quarter-wave film reflects most: ((n² − 1)/(n² + 1))²
    let quarter = reflected(1.0 - 550.0 / (4.0 * 1.33 * 400.0));
    assert!((quarter - 0.0771).abs() < 1e-3, "{quarter}");
}

#[test]
fn what_is_no_stack_is_refused() {
    let message = |parameters: &str| read("layered", parameters, Layered::read).unwrap_err();
    for (parameters, expected) in [
        (
            "",
            "scene.xml:1:24: bsdf 'layered' has neither films nor a substrate, expected 'thickness' and 'ior', or \
             'int_ior'",
        ),
        (
            "<string name='thickness' value='100nm, 0nm'/><string name='ior' value='1.4, 1.5'/>",
            "scene.xml:2:1: film 2 of bsdf 'layered' has a thickness of 0 m, expected a positive length; leave the \
             film out if there is none",
        ),
        (
            "<string name='thickness' value='100nm'/><string name='ior' value='1.4, 1.5'/>",
            "scene.xml:2:1: bsdf 'layered' has 1 length in 'thickness' and 2 indices in 'ior', expected one of each \
             for every film",
        ),
        (
            "<string name='thickness' value='100nm'/>",
            "scene.xml:2:1: bsdf 'layered' has 1 length in 'thickness' and 0 indices in 'ior', expected one of each \
             for every film",
        ),
        (
            "<string name='thickness' value='100nm'/><string name='ior' value='1.4+1i'/>",
            "scene.xml:2:41: an index of refraction of 1.4 - -1i in 'ior' of bsdf 'layered', expected eta - ki with \
             eta and k not negative, and a modulus between 1e-4 and 1e4",
        ),
        (
            "<string name='thickness' value='100nm'/><string name='ior' value='watre'/>",
            "scene.xml:2:41: unknown material 'watre', did you mean 'water'?",
        ),
        (
            "<string name='thickness' value='100nm'/><string name='ior' value='no.csv'/>",
            "scene.xml:2:41: no file 'no.csv', looked in '.'",
        ),
        (
            "<string name='int_ior' value='bk7'/><float name='thicknes' value='1'/>",
            "scene.xml:2:37: unknown parameter 'thicknes' in bsdf 'layered', did you mean 'thickness'?",
        ),
    ] {
        assert_eq!(message(parameters), expected);
    }
}

#[test]
fn wavelengths_outside_the_scenes_tables_are_refused() {
    let matter = layered(
        "<string name='thickness' value='100nm'/>\n<spectrum name='ior' value='400:1.47, 700:1.455'/>",
    );
    assert!(matter.check_wavelengths([550.0, 550.0]).is_ok());
    assert!(matter.check_wavelengths([400.0, 700.0]).is_ok());
    assert_eq!(
        matter
            .check_wavelengths([360.0, 830.0])
            .unwrap_err()
            .to_string(),
        "scene.xml:3:1: 'ior' of bsdf 'layered' is known from 400 to 700 nm, expected a table that holds 360 to 830 \
         nm; --wavelength or --bands choose others"
    );
    // named media hold their ends
    let named =
        layered("<string name='thickness' value='100nm'/><string name='ior' value='TiO2'/>");
    assert!(named.check_wavelengths([100.0, 5000.0]).is_ok());
}
