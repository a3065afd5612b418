//! Which orders of a grating an autocorrelation needs.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use num_complex::Complex64;

use super::profile::Profile;
use super::{Cell, Grating};

/// Orders are computed up to this number to each side.
const FURTHEST: i32 = 10_000;

/// Most orders of each direction of crossed lines.
const MOST_CROSSED: usize = 128;

/// Most orders of all.
const MOST: usize = 20_001;

/// Orders with their shares `p_q`, and the share of what was left out over the largest of them.
pub(super) struct Choice<Q> {
    pub(super) orders: Vec<(Q, f64)>,
    pub(super) error: f64,
}

pub(super) fn choose(grating: &Grating, phi_z: f64, tolerance: f64) -> Choice<[i32; 2]> {
    let within = |order: [i32; 2]| grating.shift(order).norm() <= grating.reach;
    match &grating.cell {
        Cell::Lines(profile) => {
            let (line, missing) = line(profile, phi_z, reach(grating, 0), tolerance);
            let orders = line.into_iter().map(|(q, p)| ([q, 0], p)).collect();
            pruned(orders, missing, tolerance, MOST)
        }
        Cell::Crossed(profiles) => {
            let axes = [0, 1].map(|i| {
                // a share of one direction counts beside the largest of the other
                let (other, _) = line(&profiles[1 - i], phi_z, reach(grating, 1 - i), 0.5);
                let part = 0.25 * tolerance * largest(&other);
                let (line, missing) = line(&profiles[i], phi_z, reach(grating, i), part);
                pruned(line, missing, part, MOST_CROSSED)
            });
            let missing = axes.iter().map(|a| a.error * largest(&a.orders)).sum();
            let [first, second] = axes.map(|axis| axis.orders);
            let pairs = first
                .iter()
                .flat_map(|(q1, p1)| second.iter().map(move |(q2, p2)| ([*q1, *q2], p1 * p2)));
            let orders = pairs.filter(|(order, _)| within(*order)).collect();
            pruned(orders, missing, tolerance, MOST)
        }
        Cell::Sampled(samples) => {
            let orders = samples
                .all_amplitudes(phi_z)
                .filter(|(order, _)| within(*order))
                .map(|(order, t)| (order, t.norm_sqr()))
                .collect();
            pruned(orders, 0.0, tolerance, MOST)
        }
    }
}

/// The last order of a direction that may be wanted.
fn reach(grating: &Grating, direction: usize) -> i32 {
    let q = grating.reach * grating.pitches[direction] / TAU;
    // the conversion saturates
    FURTHEST.min(q as i32)
}

/// The orders of one direction in a window about 0 that grows until half the tolerance lies outside, and what does.
fn line(profile: &Profile, phi_z: f64, reach: i32, tolerance: f64) -> (Vec<(i32, f64)>, f64) {
    if let Some(all) = profile.all_orders() {
        let held = (*all.start()).max(-reach)..=(*all.end()).min(reach);
        return (shares(profile, phi_z, held).collect(), 0.0);
    }
    let psi = phi_z.abs() * profile.depth();
    let mut window = reach.min((8.0 + psi) as i32);
    let mut orders: Vec<(i32, f64)> = shares(profile, phi_z, -window..=window).collect();
    loop {
        let inside: f64 = orders.iter().map(|(_, p)| p).sum();
        // the phases' rounding is no missing order
        let missing = (1.0 - inside).max(0.0);
        let noise = 4.0 * f64::EPSILON * (1.0 + psi);
        if missing <= (0.5 * tolerance * largest(&orders)).max(noise) {
            return (orders, missing);
        }
        if window == reach {
            let unreached = if reach < FURTHEST { 0.0 } else { missing };
            return (orders, unreached);
        }
        let wider = reach.min(2 * window);
        orders.extend(shares(profile, phi_z, -wider..=-window - 1));
        orders.extend(shares(profile, phi_z, window + 1..=wider));
        window = wider;
    }
}

fn shares(
    profile: &Profile,
    phi_z: f64,
    orders: RangeInclusive<i32>,
) -> impl Iterator<Item = (i32, f64)> {
    let amplitudes: Vec<Complex64> = profile.amplitudes(phi_z, orders.clone());
    orders.zip(amplitudes.into_iter().map(|t| t.norm_sqr()))
}

fn largest<Q>(orders: &[(Q, f64)]) -> f64 {
    orders.iter().map(|(_, p)| *p).fold(0.0, f64::max)
}

/// Leaves out the smallest shares while they and the `missing` stay below the tolerance of the largest, and all beyond
/// the `most`.
pub(super) fn pruned<Q: Ord + Copy>(
    mut orders: Vec<(Q, f64)>,
    missing: f64,
    tolerance: f64,
    most: usize,
) -> Choice<Q> {
    let largest = largest(&orders);
    let allowed = (tolerance * largest - missing).max(0.5 * tolerance * largest);
    orders.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut dropped = 0.0;
    while let Some((_, share)) = orders.last() {
        if dropped + share > allowed && orders.len() <= most {
            break;
        }
        dropped += share;
        orders.pop();
    }
    orders.sort_by_key(|(order, _)| *order);
    let error = if largest > 0.0 {
        (dropped + missing) / largest
    } else {
        0.0
    };
    Choice { orders, error }
}
