use std::f64::consts::TAU;
use std::path::Path;

use glam::{DVec2, DVec3, Vec3A};
use mueller16::{CoupledOrders, Mount, Profile};
use nalgebra::{Vector2, Vector3};
use stokes::Wavelength;

use super::*;
use crate::geometry::frame::Frame;
use crate::light::{MuellerResponse, Polarized, Sight};
use crate::material::Material;
use crate::sampler::SampleStream;
use crate::scene::{Overrides, build, read_text};

const GREEN: f32 = 550.0;

fn grating(parameters: &[(&str, &str)]) -> Result<(Grating, Vec<String>), String> {
    let strings: String = parameters
        .iter()
        .map(|(name, value)| {
            let tag = match *name {
                "vector" => return format!("<vector name='direction' value='{value}'/>"),
                "duty" | "apex" | "angle" | "int_ior" | "ext_ior" | "eta" | "k" => "float",
                _ => "string",
            };
            format!("<{tag} name='{name}' value='{value}'/>")
        })
        .collect();
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/>\n<bsdf type='grating'>{strings}</bsdf></scene>"
    );
    let document =
        read_text(&text, Path::new("test.xml"), &[]).map_err(|error| error.to_string())?;
    let built = build(&document, Overrides::default()).map_err(|error| error.to_string())?;
    match built.scene.materials.into_iter().next() {
        Some(Material::Grating(grating)) => Ok((*grating, document.notices())),
        other => panic!("{other:?}"),
    }
}

fn good(parameters: &[(&str, &str)]) -> Grating {
    grating(parameters).unwrap().0
}

fn vertex(o: Vec3A) -> Vertex {
    Vertex {
        o,
        position: Vec3A::ZERO,
        frame: Frame {
            s: Vec3A::X,
            t: Vec3A::Y,
            n: Vec3A::Z,
        },
        viewer_distance: 1.0,
        sight: Sight::BLIND,
    }
}

fn toward(degrees: f32, azimuth: f32) -> Vec3A {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3A::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

fn element(response: MuellerResponse<1>) -> (Vec3A, Element) {
    match response {
        MuellerResponse::Diagonal { axis, elements } => (axis, elements[0]),
        MuellerResponse::Depolarizing([m]) => {
            assert_eq!(m, 0.0);
            (Vec3A::X, Element::BLACK)
        }
        MuellerResponse::General { .. } => panic!("a general matrix"),
    }
}

/// All sharp orders of a direction: toward the light, and what they carry.
fn sharp_orders(grating: &Grating, o: Vec3A) -> Vec<(Vec3A, u32, Element)> {
    let at = vertex(o);
    let view = grating.view(&at, GREEN);
    let mut found = Vec::new();
    for &side in grating.sides(unit(o)) {
        grating.visit(&view, unit(o), side, 1.0, |order| {
            let i = order.direction.as_vec3a();
            let part = Part::Discrete(order.code());
            let (response, density) =
                grating.respond::<Polarized<1>>(&at, i, part, &[GREEN], &Coherence::PLANE_WAVE);
            assert_eq!(density, 0.0);
            let bent = grating.bend(&at, part, &[GREEN]).unwrap();
            assert!((bent - i).length() < 1e-6);
            found.push((i, order.code(), element(response).1));
        });
    }
    found
}

const LAMELLAR: [(&str, &str); 5] = [
    ("pitch", "2.9um"),
    ("depth", "150nm"),
    ("profile", "lamellar"),
    ("duty", "0.4"),
    ("angle", "30"),
];

/// An ideal mirror: r = 1 for all angles but a phase.
const MIRROR: [(&str, &str); 2] = [("eta", "0"), ("k", "1000")];

const GLASS: [(&str, &str); 2] = [("int_ior", "1.5"), ("ext_ior", "1")];

const BLAZED: [(&str, &str); 3] = [("pitch", "4um"), ("depth", "300nm"), ("profile", "blazed")];

const ROUGH: [(&str, &str); 2] = [("height", "30nm"), ("length", "6um")];

fn with(parts: &[&[(&'static str, &'static str)]]) -> Grating {
    good(&parts.concat())
}

#[test]
fn orders_are_those_of_the_grating_equation_with_the_capped_shares_of_the_phase() {
    // a second implementation, which shares among all coupled directions
    let grating = with(&[&LAMELLAR, &MIRROR]);
    let across = Vector2::new(30f64.to_radians().cos(), 30f64.to_radians().sin());
    let profile = Profile::lamellar(150e-9, 0.4).unwrap();
    let reference = mueller16::Grating::lines(2.9e-6, across, profile).unwrap();
    let green = Wavelength::from_metres(550e-9).unwrap();
    for (degrees, azimuth) in [(0.0, 0.0), (20.0, 1.0), (55.0, 4.0), (75.0, 2.0)] {
        let o = toward(degrees, azimuth);
        let from = Vector3::new(f64::from(o.x), f64::from(o.y), f64::from(o.z)).normalize();
        let mount = Mount::reflection(from, [Vector3::x(), Vector3::y()], green, 1.0).unwrap();
        let coupled = CoupledOrders::new(&reference, &mount).unwrap();
        let efficiencies = coupled.efficiencies();
        let found = sharp_orders(&grating, o);
        assert_eq!(found.len(), coupled.orders().len());
        for ((i, _, m), (order, efficiency)) in
            found.iter().zip(coupled.orders().iter().zip(efficiencies))
        {
            let expected = order.geometry.to_observer();
            let expected_i = Vec3A::new(expected.x as f32, expected.y as f32, expected.z as f32);
            assert!((*i - expected_i).length() < 1e-6, "{i} {expected_i}");
            // k = 1000 absorbs none, single precision and the table 3e-7 each
            assert!(
                (f64::from(m.mean) - efficiency).abs() < 2e-6,
                "{:?}: {} {efficiency}",
                order.index,
                m.mean
            );
        }
    }
}

#[test]
fn a_blazed_grating_sends_light_where_its_facets_mirror_it() {
    let grating = with(&[&BLAZED, &MIRROR]);
    // facets rise along U: their normal leans to −U, and so does light from above
    let strongest = sharp_orders(&grating, Vec3A::Z)
        .into_iter()
        .max_by(|a, b| a.2.mean.total_cmp(&b.2.mean))
        .unwrap();
    assert!(strongest.0.x < -0.1, "{}", strongest.0);
    // q = −2 d/λ = −1.09: order −1
    assert!((f64::from(strongest.0.x) + 0.55 / 4.0).abs() < 1e-6);
    let turned = with(&[&BLAZED, &MIRROR, &[("angle", "180")]]);
    let strongest = sharp_orders(&turned, Vec3A::Z)
        .into_iter()
        .max_by(|a, b| a.2.mean.total_cmp(&b.2.mean))
        .unwrap();
    assert!(strongest.0.x > 0.1);
}

#[test]
fn no_polarization_gains_power_and_rough_orders_lose_what_haloes_hold() {
    let cases = [
        with(&[&LAMELLAR, &MIRROR]),
        with(&[&BLAZED, &MIRROR]),
        with(&[&LAMELLAR, &GLASS]),
        with(&[&BLAZED, &GLASS]),
        with(&[
            &LAMELLAR,
            &GLASS,
            &[("pitch_v", "1.3um"), ("profile_v", "sinusoidal")],
        ]),
        with(&[&[("pitch", "1.6um"), ("depth", "350nm")], &GLASS]),
    ];
    for (case, grating) in cases.iter().enumerate() {
        for degrees in [0.0, 10.0, 30.0, 50.0, 60.0, 70.0, 80.0, 88.0] {
            for azimuth in [0.0, 1.0, 3.0] {
                for up in [1.0, -1.0] {
                    let o = toward(degrees, azimuth) * Vec3A::new(1.0, 1.0, up);
                    if !grating.faces(o) {
                        continue;
                    }
                    // the orders that light from o leaves in, by reciprocity
                    let sum: f32 = sharp_orders(grating, o)
                        .iter()
                        .map(|(i, _, m)| {
                            let n = |d: Vec3A| grating.boundary.index(d.z > 0.0) as f32;
                            (m.mean + m.difference.abs()) * (n(*i) / n(o)).powi(2)
                        })
                        .sum();
                    assert!(sum < 1.0 + 1e-5, "{case} {degrees} {azimuth}: {sum}");
                    assert!(sum > 0.3 || case > 3, "{case} {degrees} {azimuth}: {sum}");
                }
            }
        }
    }
}

/// Mean over κ of `f` times the response's weights, by a midpoint rule over the tangential plane of one side.
fn integral(side: f64, mut f: impl FnMut(Vec3A) -> f64) -> f64 {
    const N: usize = 700;
    let step = 2.0 / N as f64;
    let mut sum = 0.0;
    for a in 0..N {
        for b in 0..N {
            let t = DVec2::new(a as f64 + 0.5, b as f64 + 0.5) * step - 1.0;
            let cos2 = 1.0 - t.length_squared();
            if cos2 > 1e-4 {
                let i = t.extend(cos2.sqrt() * side);
                sum += f(i.as_vec3a()) * step * step / cos2.sqrt();
            }
        }
    }
    sum
}

#[test]
fn haloes_and_finite_orders_carry_what_is_not_sharp() {
    let sizes: [&[(&str, &str)]; 2] = [&[], &[("size", "12um")]];
    for size in sizes {
        for boundary in [&MIRROR, &GLASS] {
            let rough = with(&[&LAMELLAR, &ROUGH, boundary, size]);
            let smooth = with(&[&LAMELLAR, boundary]);
            let o = toward(20.0, 1.0);
            let at = vertex(o);
            for side in [1.0, -1.0] {
                let on_side = |i: Vec3A| f64::from(i.z) * side > 0.0;
                let whole: f64 = sharp_orders(&smooth, o)
                    .iter()
                    .filter(|(i, ..)| on_side(*i))
                    .map(|(.., m)| f64::from(m.mean))
                    .sum();
                let sharp: f64 = if size.is_empty() {
                    sharp_orders(&rough, o)
                        .iter()
                        .filter(|(i, ..)| on_side(*i))
                        .map(|(.., m)| f64::from(m.mean))
                        .sum()
                } else {
                    0.0
                };
                let lobes = integral(side, |i| {
                    let (response, _) = rough.respond::<Polarized<1>>(
                        &at,
                        i,
                        Part::Continuous,
                        &[GREEN],
                        &Coherence::PLANE_WAVE,
                    );
                    f64::from(element(response).1.mean)
                });
                // lobes reach over pass-offs and see other caps and facets: a percent of what they hold
                assert!(
                    (sharp + lobes - whole).abs() < 0.015 * whole + 1e-9,
                    "{side} {size:?}: {sharp} + {lobes}, {whole}"
                );
                // g is 0.46 in reflection, 0.03 in transmission
                assert!(whole == 0.0 || (lobes > 0.02 * whole && sharp < 0.98 * whole));
            }
        }
    }
}

#[test]
fn directions_are_drawn_with_the_density_that_is_said() {
    let cases = [
        with(&[&LAMELLAR, &MIRROR, &ROUGH]),
        with(&[&LAMELLAR, &GLASS, &ROUGH]),
        with(&[&LAMELLAR, &GLASS, &ROUGH, &[("size", "10um")]]),
    ];
    for (case, grating) in cases.iter().enumerate() {
        let at = vertex(toward(40.0, 2.0));
        let o = unit(at.o);
        let view = grating.view(&at, GREEN);
        // a function that tells lobes and places in them apart
        let probe = |i: Vec3A| f64::from((5.0 * i.x + 3.0 * i.y + i.z).sin() + 1.0);
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut sharp: std::collections::BTreeMap<u32, (f64, f64)> = Default::default();
        let n = 200_000;
        for k in 0..n {
            let stream = SampleStream::new(7, 0, k);
            let [a, b] = stream.pair(0);
            let [c, _] = stream.pair(2);
            let Some(departure) = grating.sample(&at, &[GREEN], [a, b, c]) else {
                continue;
            };
            match departure.part {
                Part::Discrete(code) => {
                    let entry = sharp.entry(code).or_default();
                    *entry = (entry.0 + 1.0, f64::from(departure.density));
                }
                _ => {
                    let value = probe(departure.direction);
                    sum += value;
                    squares += value * value;
                    let said = grating
                        .respond::<Polarized<1>>(
                            &at,
                            departure.direction,
                            Part::Continuous,
                            &[GREEN],
                            &Coherence::PLANE_WAVE,
                        )
                        .1;
                    assert!((said / departure.density - 1.0).abs() < 1e-2);
                }
            }
        }
        let n = n as f64;
        for (code, (count, probability)) in sharp {
            let error = (probability * (1.0 - probability) / n).sqrt();
            assert!(
                (count / n - probability).abs() < 5.0 * error,
                "{case} {code:x}: {} {probability}",
                count / n
            );
        }
        let (mean, square) = (sum / n, squares / n);
        let error = ((square - mean * mean) / n).sqrt();
        let expected: f64 = grating
            .sides(o)
            .iter()
            .map(|&side| integral(side, |i| probe(i) * grating.density(&view, unit(i), o)))
            .sum();
        // the midpoint rule is exact to 1e-4 for lobes of some cells
        assert!(
            (mean - expected).abs() < 5.0 * error + 3e-4,
            "{case}: {mean} {expected} ± {error}"
        );
    }
}

#[test]
fn responses_are_reciprocal() {
    for grating in [
        with(&[&LAMELLAR, &GLASS]),
        with(&[&BLAZED, &GLASS]),
        with(&[&BLAZED, &[("eta", "1.2"), ("k", "6")]]),
    ] {
        for (degrees, azimuth) in [(20.0, 1.0), (55.0, 4.0), (75.0, 2.0)] {
            let o = toward(degrees, azimuth);
            for (i, code, m) in sharp_orders(&grating, o) {
                // back along it: the light comes from o, in the same order
                let back = sharp_orders(&grating, i);
                let (_, _, b) = back
                    .iter()
                    .find(|(d, ..)| (*d - o).length() < 1e-4)
                    .unwrap_or_else(|| panic!("no way back of {code:x}"));
                let n = |d: Vec3A| grating.boundary.index(d.z > 0.0) as f32;
                let there = m.scaled((n(i) / n(o)).powi(2));
                let here = b.scaled((n(o) / n(i)).powi(2));
                for (a, b) in [
                    (there.mean, here.mean),
                    (there.difference, here.difference),
                    (there.cosine, here.cosine),
                    (there.sine, here.sine),
                ] {
                    assert!((a - b).abs() < 1e-5, "{code:x}: {m:?} {b:?}");
                }
            }
        }
    }
    let rough = with(&[&BLAZED, &GLASS, &ROUGH, &[("size", "5um")]]);
    for (o, i) in [
        (toward(20.0, 1.0), toward(28.0, 4.1)),
        (toward(20.0, 1.0), toward(167.0, 4.1)),
    ] {
        let weight = |o: Vec3A, i: Vec3A| {
            let response = rough.respond::<Polarized<1>>(
                &vertex(o),
                i,
                Part::Continuous,
                &[GREEN],
                &Coherence::PLANE_WAVE,
            );
            let n = rough.boundary.index(o.z > 0.0);
            f64::from(element(response.0).1.mean / i.z.abs()) / (n * n)
        };
        let (there, back) = (weight(o, i), weight(i, o));
        assert!(
            there > 1e-3 && (there / back - 1.0).abs() < 1e-4,
            "{there} {back}"
        );
    }
}

#[test]
fn light_of_a_patch_is_the_average_over_its_directions() {
    let grating = with(&[&LAMELLAR, &GLASS, &ROUGH, &[("size", "40um")]]);
    let at = vertex(toward(30.0, 0.5));
    let view = grating.view(&at, GREEN);
    let o = unit(at.o);
    // near order 1 in reflection, off its middle
    let order = sharp_orders(&with(&[&LAMELLAR, &GLASS]), at.o)[5].0;
    let i = unit(order + Vec3A::new(1.5e-3, -1e-3, 0.0));
    let rows = [
        Vec3A::new(2e-3, 1e-3, 0.0),
        Vec3A::new(-0.5e-3, 1.5e-3, 0.0),
    ];
    let coherence = Coherence {
        angular_root: rows,
        distance: 1.0,
    };
    let found = grating.lobe(&view, i, o, &grating.spread(&view, &at, i, &coherence));
    // φ_z stays that of the centre: only the tangential direction moves
    let (mut sum, mut weights) = (0.0, 0.0);
    const N: i32 = 60;
    for a in -N..=N {
        for b in -N..=N {
            let (x, y) = (f64::from(a) * 0.1, f64::from(b) * 0.1);
            let weight = (-0.5 * (x * x + y * y)).exp();
            let turn = rows[0].as_dvec3() * x + rows[1].as_dvec3() * y;
            sum += weight
                * grating.lobe(
                    &view,
                    DVec3::new(i.x + turn.x, i.y + turn.y, i.z),
                    o,
                    &[0.0; 3],
                );
            weights += weight;
        }
    }
    // the trapezoidal rule is exact to e^(−200) for Gaussians; lobes are cut at e^(−32)
    assert!(
        (found / (sum / weights) - 1.0).abs() < 1e-6,
        "{found} {}",
        sum / weights
    );
}

#[test]
fn a_direction_in_space_is_projected_and_crossed_lines_have_orders_in_both() {
    let local = with(&[&BLAZED, &MIRROR, &[("angle", "90")]]);
    let world = with(&[&BLAZED, &MIRROR, &[("vector", "0, 2, 5")]]);
    let o = toward(25.0, 0.3);
    for (a, b) in sharp_orders(&local, o).iter().zip(sharp_orders(&world, o)) {
        assert!((a.0 - b.0).length() < 1e-6 && (a.2.mean - b.2.mean).abs() < 1e-6);
    }
    let crossed = good(
        &[
            &[
                ("pitch", "2um"),
                ("depth", "80nm"),
                ("pitch_v", "3um"),
                ("depth_v", "120nm"),
            ],
            &MIRROR[..],
        ]
        .concat(),
    );
    let shares: Vec<_> = sharp_orders(&crossed, Vec3A::Z);
    // order (1, −1) is at (λ/2 µm, −λ/3 µm) and has the product of J1² for its own φ_z
    let (x, y) = (0.55 / 2.0, -0.55 / 3.0);
    let cos = f64::sqrt(1.0 - x * x - y * y);
    let k = TAU / 550e-9;
    let j1 = |depth: f64| libm::jn(1, 0.5 * k * (1.0 + cos) * depth).powi(2);
    let found = shares
        .iter()
        .find(|(i, ..)| (i.x - x as f32).abs() < 1e-5 && (i.y - y as f32).abs() < 1e-5)
        .unwrap();
    let expected = j1(80e-9) * j1(120e-9);
    assert!(
        (f64::from(found.2.mean) - expected).abs() < 2e-6,
        "{} {expected}",
        found.2.mean
    );
}

#[test]
fn bad_gratings_are_refused_in_words_and_doubtful_ones_noticed() {
    let refused = |parameters: &[(&str, &str)]| grating(parameters).unwrap_err();
    let base = [("pitch", "1.6um"), ("depth", "120nm")];
    for (more, expected) in [
        (
            &[("pitch", "3"), ("depth", "1nm")][..],
            "length 'pitch' of bsdf 'grating' is '3', expected a number and a unit",
        ),
        (
            &[("depth", "1nm")],
            "bsdf 'grating' has no parameter 'pitch', expected a length",
        ),
        (
            &[("pitch", "2um")],
            "bsdf 'grating' has no parameter 'depth', expected a length",
        ),
        (
            &[("pitch", "0um"), ("depth", "1nm")],
            "expected a length from 1 nm to 1 mm",
        ),
        (
            &[base[0], base[1], ("profile", "lamelar")],
            "did you mean 'lamellar'?",
        ),
        (
            &[base[0], base[1], ("profile", "lamellar"), ("duty", "1.5")],
            "expected a number from 0 to 1",
        ),
        (
            &[base[0], base[1], ("vector", "0 0 0")],
            "'direction' is along nothing",
        ),
        (
            &[base[0], base[1], ("vector", "1 0 0"), ("angle", "3")],
            "both 'angle' and 'direction'",
        ),
        (
            &[base[0], base[1], ("height", "3nm")],
            "has no parameter 'length'",
        ),
        (
            &[base[0], base[1], ("size", "0um")],
            "expected a positive length",
        ),
        (
            &[base[0], base[1], ("material", "Al"), ("int_ior", "1.5")],
            "both 'material' and 'int_ior'",
        ),
        (
            &[base[0], base[1], ("duty", "0.3")],
            "unknown parameter 'duty'",
        ),
    ] {
        let message = refused(more);
        assert!(
            message.starts_with("test.xml:2:") && message.contains(expected),
            "{message}"
        );
    }
    let noticed = |parameters: &[(&str, &str)]| grating(parameters).unwrap().1.join("\n");
    assert!(noticed(&[("pitch", "9um"), ("depth", "3um")]).contains("a depth of 0.33 pitches"));
    assert_eq!(noticed(&[("pitch", "9um"), ("depth", "1um")]), "");
}

#[test]
fn short_pitches_are_doubted_at_the_wavelengths_that_are_rendered() {
    let fine = good(&[("pitch", "300nm"), ("depth", "10nm")]);
    for (range, expected) in [
        (
            [550.0, 550.0],
            "good for pitches above five wavelengths: here below 60 nm",
        ),
        ([360.0, 830.0], "only order 0 propagates above 600 nm"),
        ([700.0, 700.0], "only order 0 propagates above 600 nm"),
    ] {
        let [doubt] = &fine.doubts(range)[..] else {
            panic!("{range:?}")
        };
        assert!(
            doubt.starts_with("test.xml:2:") && doubt.contains(expected),
            "{doubt}"
        );
    }
    let coarse = good(&[("pitch", "3um"), ("depth", "120nm")]);
    assert!(coarse.doubts([550.0, 600.0]).is_empty());
    assert!(coarse.doubts([550.0, 601.0])[0].contains("here below 600 nm"));
    // in glass waves are shorter
    let glass = good(&[("pitch", "300nm"), ("depth", "10nm"), ("int_ior", "1.5")]);
    assert!(glass.doubts([830.0, 830.0])[0].contains("here below 90 nm"));
}
