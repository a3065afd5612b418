//! The reciprocal energy cap of random heights, `1/max(1, A(i), A(o))`.
//!
//! ```text
//! A(i) = ∫ f cos_o dω/(1 − e^(−g)),     all facets lossless, g of the mirror or Snell pair
//! ```
//!
//! For glass A is that of reflection and refraction together, with Fresnel's powers on the facets, over what is not sharp:
//! facets that lean toward grazing light let more of it in than the mean surface keeps back.
//!
//! Scattering of the first order makes too much light at grazing incidence on short correlations; with the cap mirror and
//! diffuse light together hold at most what came. Where A is below 1 the cap is idle.
//!
//! A depends on the angle and on σ/λ, l/λ: a table over ln cos and over ln λ, whose rows are made when a wavelength first
//! asks for them, each from itself alone: the same whoever asks first. Interpolation errs by some 0.3 %, quadrature less.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use glam::Vec3A;

use super::pair::{Blur, Lit, Media};
use super::relief::Heights;

/// Shortest wavelength with a row, nm.
const SHORTEST: f32 = 100.0;
/// Rows for each doubling of the wavelength.
const PER_OCTAVE: f32 = 4.0;
/// Rows: up to 3 mm.
const ROWS: usize = 61;
/// Angles of a row, equally spaced in ln cos.
const ANGLES: usize = 32;
/// ln of the least cosine, 1e-3.
const LOWEST: f32 = -6.907_755;

/// Gauss and Legendre's rule on [−1, 1]: places and weights of its positive half.
const RULE: [[f32; 2]; 4] = [
    [0.183_434_64, 0.362_683_78],
    [0.525_532_4, 0.313_706_65],
    [0.796_666_5, 0.222_381_03],
    [0.960_289_86, 0.101_228_54],
];

/// ln A over the angles of light from one side.
#[derive(Clone, Debug)]
struct Table {
    values: [f32; ANGLES],
    /// Nowhere above 0.
    idle: bool,
}

/// The energy cap of a surface, for light from each of its sides.
#[derive(Clone, Debug)]
pub(super) struct Cap {
    /// By the side of the light.
    sides: Vec<Vec<Media>>,
    rows: Vec<OnceLock<Vec<Table>>>,
}

impl Cap {
    /// For surfaces that let light from each side go by these passages.
    pub(super) fn new(sides: Vec<Vec<Media>>) -> Self {
        Self {
            sides,
            rows: vec![OnceLock::new(); ROWS],
        }
    }

    /// ln A for light of a wavelength (nm) that comes to a side at a cosine; `share` is the power by which the facet of a passage answers at a cosine.
    #[inline]
    pub(super) fn log_ratio(
        &self,
        heights: &Heights,
        side: usize,
        wavelength: f32,
        cos: f32,
        share: impl Fn(&Media, f32) -> f32 + Copy,
    ) -> f32 {
        let place = ((wavelength / SHORTEST).log2() * PER_OCTAVE).clamp(0.0, (ROWS - 1) as f32);
        let index = (place as usize).min(ROWS - 2);
        let blend = place - index as f32;
        let [a, b] = [index, index + 1].map(|row| &self.row(heights, row, share)[side]);
        if a.idle && b.idle {
            return 0.0;
        }
        let at = (1.0 - cos.abs().max(1e-30).ln() / LOWEST) * (ANGLES - 1) as f32;
        // below the least cosine the line goes on
        let angle = (at.max(0.0) as usize).min(ANGLES - 2);
        let t = at - angle as f32;
        let value = |table: &Table| {
            table.values[angle] + t * (table.values[angle + 1] - table.values[angle])
        };
        let first = value(a);
        first + blend * (value(b) - first)
    }

    fn row(
        &self,
        heights: &Heights,
        row: usize,
        share: impl Fn(&Media, f32) -> f32 + Copy,
    ) -> &[Table] {
        self.rows[row].get_or_init(|| {
            let wavelength = SHORTEST * (row as f32 / PER_OCTAVE).exp2();
            let lit = Lit::new(heights, wavelength);
            let table = |passages: &Vec<Media>| {
                let values: [f32; ANGLES] = std::array::from_fn(|angle| {
                    let ln_cos = LOWEST * (1.0 - angle as f32 / (ANGLES - 1) as f32);
                    let (mut diffuse, mut rest) = (0.0, 0.0);
                    for media in passages {
                        let [lobe, room] =
                            powers(&lit, *media, ln_cos.exp(), |cos| share(media, cos));
                        diffuse += lobe;
                        rest += room;
                    }
                    (diffuse / rest.max(1e-30)).max(1e-30).ln()
                });
                // what quadrature in single precision cannot tell from 1
                let idle = values.iter().all(|v| *v < 2e-4);
                Table { values, idle }
            };
            self.sides.iter().map(table).collect()
        })
    }
}

/// Diffuse power of light at a cosine, and what the sharp part leaves of the facet's own, `M(n) (1 − e^(−g))`.
///
/// By quadrature over the disk of outgoing tangential directions about the mirror or Snell direction: panels that double
/// outward from the width of the lobe, the last one graded toward the rim. `share` is a facet's power at a cosine.
pub(super) fn powers(
    lit: &Lit<'_>,
    media: Media,
    cos_i: f32,
    share: impl Fn(f32) -> f32,
) -> [f32; 2] {
    let room = -(-lit.specular_variance(media.reversed(), cos_i)).exp_m1();
    if room <= 0.0 {
        return [0.0; 2];
    }
    let sin_i = (1.0 - cos_i * cos_i).max(0.0).sqrt();
    let i = Vec3A::new(sin_i, 0.0, cos_i);
    let centre = (media.n_i / media.n_o * sin_i).min(1.0);
    let below = if media.transmitted { -1.0 } else { 1.0 };
    let width = lit.narrowest(media.reversed(), cos_i) / media.n_o;
    let at = |radius: f32, cos: f32, sin: f32| {
        let (x, y) = (radius * cos - centre, radius * sin);
        let cos_o = (1.0 - x * x - y * y).max(1e-7).sqrt();
        let o = Vec3A::new(x, y, below * cos_o);
        let power = lit.power(media, i, o, &Blur::NONE) / (cos_o * cos_i);
        if power > 0.0 {
            let h = media.momentum(i, o).normalize();
            power * share(i.dot(h).abs().min(1.0))
        } else {
            0.0
        }
    };
    let nodes = || RULE.into_iter().flat_map(|[x, w]| [[-x, w], [x, w]]);
    let mut sum = 0.0;
    for quarter in [0.0, FRAC_PI_2] {
        for [x, w] in nodes() {
            let (sin, cos) = (quarter + 0.5 * FRAC_PI_2 * (1.0 + x)).sin_cos();
            let rim = centre * cos + (1.0 - (centre * sin).powi(2)).max(0.0).sqrt();
            let (mut from, mut to) = (0.0, width);
            let mut along = 0.0;
            loop {
                let last = to > 0.5 * rim;
                if last {
                    to = rim;
                }
                for [x, w] in nodes() {
                    let t = 0.5 * (1.0 + x);
                    // the rim's cosine vanishes as a square root
                    let (place, slope) = if last {
                        (1.0 - (1.0 - t) * (1.0 - t), 2.0 * (1.0 - t))
                    } else {
                        (t, 1.0)
                    };
                    let radius = from + (to - from) * place;
                    along += 0.5 * w * (to - from) * slope * radius * at(radius, cos, sin);
                }
                if last {
                    break;
                }
                (from, to) = (to, 2.0 * to);
            }
            // both halves of the turn
            sum += 2.0 * 0.25 * PI * w * along;
        }
    }
    [sum, room * share(cos_i)]
}
