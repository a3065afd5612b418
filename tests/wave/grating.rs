//! Gratings: orders at their angles with their powers, seen as lamps in the grating.

use std::f64::consts::{PI, TAU};

use brewster_tests::{Shot, mean, scene};
use glam::DVec3;

pub(crate) const LAMBDA: f64 = 550e-9;

/// Mean of a one-pixel image and its standard error, with patches of the given size.
fn seen(text: &str, spp: u64, patch: f32) -> (f64, f64) {
    let shot = Shot {
        patch: Some(patch),
        ..Shot::new(spp)
    };
    let (s, error) = mean(&shot.of_text(text), 0);
    (s[0], error[0])
}

/// A lamp of radiance 1 and radius `angle` (radians) around a direction, a metre from the origin, which it faces.
fn lamp(direction: DVec3, angle: f64) -> String {
    let d = direction.normalize();
    let up = if d.x.abs() < 0.9 {
        "1, 0, 0"
    } else {
        "0, 1, 0"
    };
    format!(
        "<shape type='disk'><transform name='to_world'><scale value='{angle}'/>
            <lookat origin='{}, {}, {}' target='0, 0, 0' up='{up}'/></transform>
            <emitter type='area'><float name='radiance' value='1'/></emitter></shape>",
        d.x, d.y, d.z
    )
}

/// A small grating at the origin, its normal along z and axis U along x, seen from a direction.
pub(crate) fn view(parameters: &str, from: DVec3, lamp: &str) -> String {
    let o = from.normalize() * 2.0;
    scene(
        3,
        &format!(
            "origin='{}, {}, {}' target='0, 0, 0' up='0.1, 1, 0.1'",
            o.x, o.y, o.z
        ),
        0.01,
        &format!(
            "<shape type='rectangle'><transform name='to_world'><scale value='0.01'/></transform>
             <bsdf type='grating'>{parameters}</bsdf></shape>{lamp}"
        ),
    )
}

/// Incident direction of order q for light that leaves along o: pitch p across x, indices of its side and the viewer's.
pub(crate) fn incident(o: DVec3, q: i32, p: f64, [n_i, n_o]: [f64; 2], side: f64) -> Option<DVec3> {
    let x = (f64::from(q) * LAMBDA / p - n_o * o.x) / n_i;
    let y = -n_o * o.y / n_i;
    let cos2 = 1.0 - x * x - y * y;
    (cos2 > 0.0).then(|| DVec3::new(x, y, side * cos2.sqrt()))
}

/// |t_q|² of a lamellar profile.
pub(crate) fn lamellar(q: i32, psi: f64, f: f64) -> f64 {
    let step = 2.0 * (1.0 - psi.cos());
    match q {
        0 => 1.0 - f * (1.0 - f) * step,
        _ => step * ((PI * f64::from(q) * f).sin() / (PI * f64::from(q))).powi(2),
    }
}

/// sinc² of a profile that rises along x.
fn blazed(q: i32, psi: f64) -> f64 {
    let x = PI * (f64::from(q) + psi / TAU);
    if x.abs() < 1e-9 {
        1.0
    } else {
        (x.sin() / x).powi(2)
    }
}

/// Sum of what the orders of a direction carry, `k d (cos + cos_q)` in each.
pub(crate) fn total(d: DVec3, p: f64, depth: f64, share: impl Fn(i32, f64) -> f64) -> f64 {
    (-20..=20)
        .filter_map(|q| {
            let e = incident(d, q, p, [1.0, 1.0], 1.0)?;
            Some(share(q, TAU / LAMBDA * depth * (d.z + e.z)))
        })
        .sum()
}

#[test]
fn lamps_are_seen_in_every_order_with_its_power_also_in_conical_mounts() {
    let (p, depth, f) = (4e-6, 110e-9, 0.35);
    let share = |q: i32, psi: f64| lamellar(q, psi, f);
    let parameters = "<string name='pitch' value='4um'/><string name='depth' value='110nm'/>
        <string name='profile' value='lamellar'/><float name='duty' value='0.35'/>
        <float name='eta' value='0'/><float name='k' value='10000'/>";
    // in the plane across the grooves, and conical
    for o in [DVec3::new(0.3, 0.0, 1.0), DVec3::new(0.2, 0.6, 1.0)] {
        let o = o.normalize();
        for q in -3..=3 {
            let i = incident(o, q, p, [1.0, 1.0], 1.0).unwrap();
            let cap = total(o, p, depth, share)
                .max(total(i, p, depth, share))
                .max(1.0);
            let expected = share(q, TAU / LAMBDA * depth * (o.z + i.z)) / cap;
            // the weakest order carries 8e-4: some thirty samples of these
            let (found, error) = seen(&view(parameters, o, &lamp(i, 0.01)), 40_000, 0.5);
            // angles within the pixel and the table of shares: 1e-4
            assert!(
                (found - expected).abs() < 5.0 * error + 1e-4,
                "{o} order {q}: {found} ± {error}, {expected}"
            );
            // half way to the next order there is nothing
            let off = (i + DVec3::X * 0.5 * LAMBDA / p).normalize();
            assert_eq!(
                seen(&view(parameters, o, &lamp(off, 0.01)), 200, 0.5).0,
                0.0
            );
        }
    }
}

#[test]
fn a_blaze_shines_on_the_side_that_its_facets_face() {
    let (p, depth) = (8e-6, 275e-9);
    let parameters = "<string name='pitch' value='8um'/><string name='depth' value='275nm'/>
        <string name='profile' value='blazed'/><float name='eta' value='0'/><float name='k' value='10000'/>";
    let o = DVec3::new(0.0, 0.1, 1.0).normalize();
    // facets rise along +x: their normals lean to −x, and light from −x comes up to the viewer
    for q in [-2, -1, 0, 1] {
        let i = incident(o, q, p, [1.0, 1.0], 1.0).unwrap();
        let cap = total(o, p, depth, blazed)
            .max(total(i, p, depth, blazed))
            .max(1.0);
        let expected = blazed(q, TAU / LAMBDA * depth * (o.z + i.z)) / cap;
        // the weakest order carries 8e-4: some thirty samples of these
        let (found, error) = seen(&view(parameters, o, &lamp(i, 0.01)), 40_000, 0.5);
        assert!(
            (found - expected).abs() < 5.0 * error + 1e-4,
            "order {q}: {found} ± {error}, {expected}"
        );
        assert_eq!(q == -1, found > 0.9, "order {q}: {found}");
    }
}

#[test]
fn orders_pass_into_glass_at_their_angles_with_its_radiance() {
    let (p, depth, n) = (6e-6, 300e-9, 1.5);
    let parameters = "<string name='pitch' value='6um'/><string name='depth' value='300nm'/>
        <string name='profile' value='lamellar'/><float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>";
    let o = DVec3::new(0.25, 0.0, 1.0).normalize();
    for q in [-2, -1, 0, 1, 2] {
        let i = incident(o, q, p, [n, 1.0], -1.0).unwrap();
        let phi = TAU / LAMBDA * (o.z + n * i.z);
        // Fresnel at the facet that refracts i into o
        let h = (o + n * i).normalize();
        let (c_i, c_o) = (h.dot(i).abs(), h.dot(o).abs());
        let t = |a: f64, b: f64| 4.0 * a * b / (a + b).powi(2);
        let fresnel = 0.5 * (t(n * c_i, c_o) + t(c_i, n * c_o));
        let expected = lamellar(q, phi * depth, 0.5) * fresnel / (n * n);
        let (found, error) = seen(&view(parameters, o, &lamp(i, 0.01)), 8000, 0.5);
        // shares of glass add up to less than 1 here up to a cap of a percent
        assert!(
            (found - expected).abs() < 5.0 * error + 1e-4 + 0.01 * expected,
            "order {q}: {found} ± {error}, {expected}"
        );
    }
}

const FINITE: &str = "<string name='pitch' value='4um'/><string name='depth' value='110nm'/>
    <string name='profile' value='lamellar'/><string name='material' value='Al'/>";

#[test]
fn a_finite_grating_has_the_orders_of_an_infinite_one_but_wider() {
    let o = DVec3::new(0.3, 0.2, 1.0).normalize();
    for q in [-1, 0, 2] {
        let i = incident(o, q, 4e-6, [1.0, 1.0], 1.0).unwrap();
        let sharp = seen(&view(FINITE, o, &lamp(i, 0.03)), 20_000, 0.5);
        let size = format!("{FINITE}<string name='size' value='30um'/>");
        let wide = seen(&view(&size, o, &lamp(i, 0.03)), 4000, 0.5);
        // lobes of 3 mrad are all within the lamp; efficiencies vary within a lobe by its square
        assert!(
            (sharp.0 - wide.0).abs() < 5.0 * (sharp.1 + wide.1) + 1e-3,
            "order {q}: {sharp:?} {wide:?}"
        );
        // a lamp as wide as half the lobe sees a part of it: 1 − e^(−a²/2s²), s² = (λ/2πw)² (1, 1/cos²)
        let small = seen(&view(&size, o, &lamp(i, 0.002)), 4000, 0.5);
        assert!(small.0 < 0.5 * wide.0, "{small:?} {wide:?}");
    }
}

#[test]
fn patches_of_any_size_below_the_rule_give_the_same_light() {
    let size = format!(
        "{FINITE}<string name='size' value='30um'/><string name='height' value='20nm'/><string name='length' value='20um'/>"
    );
    let o = DVec3::new(0.3, 0.2, 1.0).normalize();
    let i = incident(o, 1, 4e-6, [1.0, 1.0], 1.0).unwrap();
    // at the rim of a lobe of 3 mrad
    let text = view(&size, o, &lamp(i + DVec3::new(0.003, 0.001, 0.0), 0.003));
    let plane = seen(&text, 100_000, 0.0);
    for patch in [0.125, 0.25, 0.5] {
        let found = seen(&text, 4000, patch);
        // the Gaussian of a cell of half a lobe's width errs by 1e-3 of the peak
        assert!(
            (found.0 - plane.0).abs() < 5.0 * (found.1 + plane.1) + 2e-3 * plane.0,
            "{patch}: {found:?} {plane:?}"
        );
    }
}
