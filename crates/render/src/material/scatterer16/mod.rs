//! `scatterer16`: any locally stationary matter of Theorem S4.1, from a file of populations.
//!
//! | parameter  | type     | meaning                                                                    | default |
//! |------------|----------|----------------------------------------------------------------------------|---------|
//! | `filename` | string   | JSON file of the populations                                               | –       |
//! | `centre`   | point    | where the envelopes have their origin, m, in the world                     | 0, 0, 0 |
//! | `scale`    | spectrum | factor on everything that is scattered, at most 1                          | 1       |
//!
//! ```xml
//! <bsdf type="scatterer16"><string name="filename" value="pearl.json"/></bsdf>
//! ```
//!
//! The file holds `{"populations": […]}`, each with
//!
//! - what it does at one point: a Jones matrix `T`, a Mueller matrix `M`, or sixteen numbers `sixteen` that need not be
//!   realizable by themselves; four rows l of four channels j → l;
//! - its autocorrelation `R`, in the words of `brewster eval`: `{"kind": "gaussian", "S": [[1e-12, 0], [0, 4e-12]]}`,
//!   covariance in m², and so on; without a matrix four rows of four autocorrelations or nulls;
//! - `side`: `"reflection"` unless given, or `"transmission"`;
//! - its envelope `I` on the surface, `{"kind": "disk", "radius": 0.01}`, peak 1, everywhere unless given.
//!
//! ```json
//! {"populations": [
//!     {"M": [[0.5,0,0,0],[0,0.5,0,0],[0,0,-0.5,0],[0,0,0,-0.5]], "R": {"kind": "constant"}},
//!     {"T": [[0.5,0],[0,0]], "R": {"kind": "gaussian", "S": [[4e-12,0],[0,4e-12]]}, "side": "transmission"}]}
//! ```
//!
//! Frames: axis U projected across each ray, which is that of the front; in transmission from behind, the matrix is the
//! reciprocal one, in reflection from behind the same. Vacuum on both sides.
//!
//! ```text
//! f = (1/λ²) I Σ M F{R γ}(φ_t),   φ_t = k (o + i)_t,   γ the coherence of the incident light
//! ```
//!
//! Parts of R that do not decay are a mirror, the straight way, and sharp orders. The others are drawn from the sum of
//! their Gaussians, those wider than half the hemisphere from its cosine.
//!
//! Source: Theorem S4.1 of Steinberg and Yan's supplemental; the factor of the cosines is that of flat matter.

mod lobes;
mod side;

use glam::Vec3A;
use mueller16::{ChannelSet, Matter as Stationary, Population};
use nalgebra::{Matrix2, Matrix4, Vector2};
use stokes::{Envelope, Mueller, Wavelength};

use super::{Departure, Effect, Matter, Part, Traits, Vertex, narrowed};
use crate::coherence::Coherence;
use crate::eval::population::{self, populations};
use crate::geometry::frame::Frame;
use crate::light::Light;
use crate::scene::{Object, SceneError};
use crate::spectrum::Spectrum;
use lobes::Order;
use side::{Answer, Side};

/// Most envelopes.
const ENVELOPES: usize = 8;

/// Rounding by which matter may miss being realizable or passive.
const TOLERANCE: f64 = 1e-6;

/// Lobes wider than this, radians, take light as from single points.
const WIDE: f32 = 0.1;

/// Locally stationary matter.
#[derive(Clone, Debug)]
pub struct Scatterer16 {
    envelopes: Vec<Envelope>,
    centre: Vec3A,
    scale: Spectrum,
    /// Reflection, transmission.
    sides: [Side; 2],
    /// What does not decay.
    orders: Vec<Order>,
    /// Least standard deviation of a lobe, rad/m.
    narrowest: f64,
    effect: Effect,
    /// The channels that are not zero.
    channels: ChannelSet,
}

impl Scatterer16 {
    /// Reads its parameters and its file.
    pub fn read(object: &Object) -> Result<Self, SceneError> {
        let path = object.path("filename")?;
        let name = path.display();
        let refuse = |problem: String| object.error_at("filename", format!("{name}: {problem}"));
        let text = std::fs::read(&path).map_err(|e| refuse(e.to_string()))?;
        let file: serde_json::Value =
            serde_json::from_slice(&text).map_err(|e| refuse(e.to_string()))?;
        let parts = populations(&file).map_err(|e| refuse(e.to_string()))?;
        let [x, y, z] = object.optional_point("centre")?.unwrap_or_default();
        let matter = Self::new(
            &parts,
            Vec3A::new(x as f32, y as f32, z as f32),
            object.factor("scale")?,
        )
        .map_err(refuse)?;
        if parts
            .iter()
            .any(|part| !part.transmits && !is_reciprocal(&part.mueller))
        {
            object.notice_at(
                "filename",
                format!("{name}: a population reflects otherwise than X Mᵀ X, X = diag(1, 1, -1, 1): it is not reciprocal"),
            );
        }
        Ok(matter)
    }

    fn new(parts: &[population::Part], centre: Vec3A, scale: Spectrum) -> Result<Self, String> {
        let mut matter = Self {
            envelopes: vec![],
            centre,
            scale,
            sides: <[Side; 2]>::default(),
            orders: vec![],
            narrowest: f64::INFINITY,
            effect: Effect::default(),
            channels: ChannelSet::EMPTY,
        };
        for part in parts {
            matter.add(part);
        }
        if matter.envelopes.len() > ENVELOPES {
            return Err(format!(
                "key 'populations': {} different envelopes, expected at most {ENVELOPES}",
                matter.envelopes.len()
            ));
        }
        for transmits in [false, true] {
            check_realizable(parts.iter().filter(|part| part.transmits == transmits))?;
        }
        check_passive(parts)?;
        let narrowest = matter.sides.iter().map(Side::narrowest);
        matter.narrowest = narrowest.fold(f64::INFINITY, f64::min);
        Ok(matter)
    }

    fn add(&mut self, part: &population::Part) {
        let envelope = match self.envelopes.iter().position(|e| *e == part.envelope) {
            Some(place) => place,
            None => {
                self.envelopes.push(part.envelope.clone());
                self.envelopes.len() - 1
            }
        };
        let side = &mut self.sides[usize::from(part.transmits)];
        let m = part.mueller.to_matrix();
        for (weight, place) in part.autocorrelation.deltas() {
            Order::add(
                &mut self.orders,
                part.transmits,
                place,
                (envelope, m * weight),
            );
        }
        let decaying = part.autocorrelation.clone().without_deltas();
        if decaying.term_count() > 0 {
            side.add(&m, decaying, envelope);
        }
        self.effect = self.effect.and(effect_of(&part.mueller));
        self.channels = self.channels.union(ChannelSet::of(&part.mueller));
    }

    /// The envelopes at a vertex.
    #[inline]
    fn intensities(&self, at: &Vertex) -> [f64; ENVELOPES] {
        let off = at.frame.to_local(at.position - self.centre);
        let x = Vector2::new(f64::from(off.x), f64::from(off.y));
        let mut values = [0.0; ENVELOPES];
        for (value, envelope) in values.iter_mut().zip(&self.envelopes) {
            *value = envelope.value(&x);
        }
        values
    }

    /// Sum of all shares from which a way is drawn.
    #[inline]
    fn total(&self, intensities: &[f64; ENVELOPES]) -> f64 {
        let lobes = self.sides.iter().flat_map(|side| side.shares(intensities));
        lobes.map(|(share, _)| share).sum::<f64>()
            + self
                .orders
                .iter()
                .map(|order| order.share(intensities))
                .sum::<f64>()
    }

    /// What all lobes answer, without the cosine of the light.
    #[inline]
    fn continuous(
        &self,
        at: &Vertex,
        i: Vec3A,
        k: f64,
        coherence: &Coherence,
        intensities: &[f64; ENVELOPES],
    ) -> Answer {
        let side = &self.sides[usize::from(at.o.z * i.z < 0.0)];
        let light = (!coherence.is_point()).then(|| {
            let [a, b] = coherence
                .angular_root
                .map(|row| at.frame.to_local(row).as_dvec3() * k);
            Matrix2::new(a.x, a.y, b.x, b.y)
        });
        let phi = tangential(at.o, i) * k;
        side.answer(&phi, light.as_ref(), f64::from(i.z.abs()), k, intensities)
    }
}

/// The tangential part of `o + i`.
#[inline]
fn tangential(o: Vec3A, i: Vec3A) -> Vector2<f64> {
    Vector2::new(
        f64::from(o.x) + f64::from(i.x),
        f64::from(o.y) + f64::from(i.y),
    )
}

fn is_reciprocal(mueller: &Mueller) -> bool {
    let (m, reversed) = (mueller.to_matrix(), mueller.reversed().to_matrix());
    (m - reversed).amax() <= TOLERANCE * m.amax()
}

/// What a matrix in the frames of axis U can do.
fn effect_of(mueller: &Mueller) -> Effect {
    let m = mueller.to_matrix();
    let some = |places: &[(usize, usize)]| places.iter().any(|&place| m[place] != 0.0);
    let depolarizes = (m.component_mul(&m).sum() - 4.0 * m[(0, 0)] * m[(0, 0)]).abs()
        > TOLERANCE * m.amax().powi(2);
    Effect {
        depolarizes,
        makes_linear: some(&[(1, 0), (2, 0)]),
        makes_circular: some(&[(3, 0)]),
        retards: some(&[(3, 1), (3, 2), (1, 3), (2, 3)]),
    }
}

/// Whether the channels of one side could be made of Jones matrices, lobe by lobe.
fn check_realizable<'a>(parts: impl Iterator<Item = &'a population::Part>) -> Result<(), String> {
    let parts: Vec<Population> = parts
        .map(|p| Population::of_sixteen(&p.mueller, p.autocorrelation.clone(), p.envelope.clone()))
        .collect();
    if parts.is_empty() {
        return Ok(());
    }
    let whole = |e: mueller16::MatterError| format!("key 'populations': {e}");
    let matter = Stationary::new(parts).map_err(whole)?;
    matter
        .check_realizable(&matter.lobe_places(), TOLERANCE)
        .map_err(whole)
}

/// Whether no light gains power, where all envelopes are at their peak.
fn check_passive(parts: &[population::Part]) -> Result<(), String> {
    let peak = |part: &population::Part| part.envelope.value(&Vector2::zeros()).max(0.0);
    let sum: Matrix4<f64> = parts
        .iter()
        .map(|part| part.mueller.to_matrix() * part.autocorrelation.at_zero() * peak(part))
        .sum();
    let most = sum[(0, 0)] + sum.fixed_view::<1, 3>(0, 1).norm();
    if most <= 1.0 + TOLERANCE {
        return Ok(());
    }
    Err(format!(
        "key 'populations': the matter scatters up to {most} of the light that meets it, expected at most 1; \
         multiply every 'amp' by {:.6}",
        most.recip()
    ))
}

/// The first axis of the frame of a ray: U projected across it.
#[inline]
fn axis_u(v: Vec3A) -> Vec3A {
    Frame::with_tangent(v, Vec3A::X).s
}

fn wavelength_of(wavelengths: &[f32]) -> Option<Wavelength> {
    Wavelength::from_metres(f64::from(*wavelengths.first()?) * 1e-9).ok()
}

impl Matter for Scatterer16 {
    fn sample(&self, at: &Vertex, wavelengths: &[f32], u: [f32; 3]) -> Option<Departure> {
        let o = at.o;
        let k = wavelength_of(wavelengths)?.wavenumber().radians_per_metre();
        let intensities = self.intensities(at);
        let total = self.total(&intensities);
        if o.z == 0.0 || total.is_nan() || total <= 0.0 {
            return None;
        }
        let mut left = f64::from(u[0]) * total;
        for (index, order) in self.orders.iter().enumerate() {
            let share = order.share(&intensities);
            if left < share {
                let straight = order.is_straight();
                return Some(Departure {
                    direction: if straight { -o } else { order.direction(o, k)? },
                    density: (share / total) as f32,
                    part: if straight {
                        Part::Straight
                    } else {
                        Part::Discrete(index as u32)
                    },
                    eta: 1.0,
                });
            }
            left -= share;
        }
        let lobes = [false, true].into_iter().zip(&self.sides);
        let lobes = lobes.flat_map(|(transmits, side)| {
            side.shares(&intensities)
                .map(move |(share, lobe)| (transmits, share, lobe))
        });
        let mut drawn = None;
        for (transmits, share, lobe) in lobes {
            if share > 0.0 {
                drawn = Some((transmits, lobe));
            }
            if left < share {
                break;
            }
            left -= share;
        }
        let (transmits, lobe) = drawn?;
        let up = (o.z > 0.0) != transmits;
        let direction = lobe.sample(o, up, k, [u[1], u[2]])?;
        let answer = self.continuous(at, direction, k, &Coherence::PLANE_WAVE, &intensities);
        let density = (answer.density / total) as f32;
        Departure::continuous(direction, density, 1.0)
    }

    fn respond<L: Light>(
        &self,
        at: &Vertex,
        i: Vec3A,
        part: Part,
        wavelengths: &[f32],
        coherence: &Coherence,
    ) -> (L::Response, f32) {
        let o = at.o;
        let intensities = self.intensities(at);
        let orders = |kept: &dyn Fn(usize, &Order) -> bool| {
            let kept = self
                .orders
                .iter()
                .enumerate()
                .filter(|(place, order)| kept(*place, order));
            kept.map(|(_, order)| order.matrix(&intensities)).sum()
        };
        let (matrix, density): (Matrix4<f64>, f64) = match part {
            Part::Straight => (orders(&|_, order| order.is_straight()), 0.0),
            Part::Discrete(index) => (orders(&|place, _| place == index as usize), 0.0),
            Part::Continuous => {
                let found = wavelength_of(wavelengths).map(|wavelength| {
                    let k = wavelength.wavenumber().radians_per_metre();
                    let found = self.continuous(at, i, k, coherence, &intensities);
                    (
                        found.matrix * f64::from(i.z.abs()),
                        found.density / self.total(&intensities),
                    )
                });
                found.unwrap_or_default()
            }
        };
        // through the matter from behind, the reciprocal way
        let behind = o.z * i.z < 0.0 && i.z < 0.0;
        let matrix = Mueller::from(matrix);
        let matrix = narrowed(&if behind { matrix.reversed() } else { matrix });
        let response = L::general(axis_u(o), axis_u(i), |lane| {
            matrix * self.scale.value(wavelengths[lane])
        });
        (response, density as f32)
    }

    fn lobe_width(&self, _: &Vertex, wavelengths: &[f32]) -> Option<f32> {
        let k = wavelength_of(wavelengths)?.wavenumber().radians_per_metre();
        let width = (self.narrowest / k) as f32;
        (width < WIDE).then_some(width)
    }

    fn bend(&self, at: &Vertex, part: Part, wavelengths: &[f32]) -> Option<Vec3A> {
        match part {
            Part::Straight => Some(-at.o),
            Part::Discrete(index) => {
                let k = wavelength_of(wavelengths)?.wavenumber().radians_per_metre();
                self.orders.get(index as usize)?.direction(at.o, k)
            }
            Part::Continuous => None,
        }
    }

    fn traits(&self) -> Traits {
        let discrete = self.sides.iter().all(Side::is_empty);
        Traits {
            discrete,
            straight: self.orders.iter().any(Order::is_straight),
            coherent: !discrete,
            disperses: !discrete
                || self
                    .orders
                    .iter()
                    .any(|order| !order.is_mirror_or_straight()),
            ..Traits::default()
        }
    }

    fn effect(&self) -> Effect {
        self.effect
    }

    fn left_out(&self) -> Option<String> {
        let zero = 16 - self.channels.len();
        (zero > 0).then(|| format!("{zero} of the sixteen channels, which are zero"))
    }
}

#[cfg(test)]
mod tests;
