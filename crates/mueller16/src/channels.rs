//! The sixteen channels of matter at one encounter: which are there, and the autocorrelation behind each.

use std::fmt;

use nalgebra::Matrix4;
use smallvec::SmallVec;
use stokes::Mueller;

use crate::autocorrelation::Autocorrelation;

/// A set of channels `j → l`, from the incident Stokes parameter j to the outgoing l.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ChannelSet(u16);

impl ChannelSet {
    /// No channel.
    pub const EMPTY: Self = Self(0);
    /// The intensity's own, `0 → 0`.
    pub const INTENSITY: Self = Self(1);
    /// The four `j → j`.
    pub const DIAGONAL: Self = Self(0x8421);
    /// Two blocks of four, of (S0, S1) and (S2, S3): what keeps the axes of its frame apart.
    pub const BLOCKS: Self = Self(0xcc33);
    /// All sixteen.
    pub const ALL: Self = Self(0xffff);

    /// The elements of a matrix that are not 0.
    #[must_use]
    pub fn of(mueller: &Mueller) -> Self {
        let mut set = 0;
        for l in 0..4 {
            for j in 0..4 {
                set |= u16::from(mueller.element(l, j) != 0.0) << (4 * l + j);
            }
        }
        Self(set)
    }

    /// Whether `j → l` is among them; both in `0..4`.
    #[inline]
    #[must_use]
    pub fn contains(self, j: usize, l: usize) -> bool {
        self.0 >> (4 * l + j) & 1 == 1
    }

    /// Whether every channel is also in `other`.
    #[must_use]
    pub fn is_within(self, other: Self) -> bool {
        self.0 & !other.0 == 0
    }

    /// The channel `j → l`, if there is just one.
    #[inline]
    fn single(self) -> Option<(usize, usize)> {
        let place = self.0.trailing_zeros() as usize;
        self.0.is_power_of_two().then_some((place % 4, place / 4))
    }

    /// Channels of either.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Number of channels, at most 16.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// For each incident parameter j, whether a channel starts there.
    #[inline]
    #[must_use]
    pub fn sources(self) -> [bool; 4] {
        std::array::from_fn(|j| self.0 & (0x1111 << j) != 0)
    }

    /// For each outgoing parameter l, whether a channel ends there.
    #[must_use]
    pub fn targets(self) -> [bool; 4] {
        std::array::from_fn(|l| self.0 & (0xf << (4 * l)) != 0)
    }
}

impl fmt::Display for ChannelSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match *self {
            Self::EMPTY => "none",
            Self::INTENSITY => "intensity",
            set if set.is_within(Self::DIAGONAL) => "diagonal",
            set if set.is_within(Self::BLOCKS) => "blocks",
            _ => "full",
        };
        write!(f, "{} ({name})", self.len())
    }
}

/// Channels with one autocorrelation and one envelope: sixteen numbers `R^(j→l)(x) = M_lj R(x)`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    pub(crate) mueller: Matrix4<f64>,
    pub(crate) set: ChannelSet,
    pub(crate) autocorrelation: Autocorrelation,
    pub(crate) envelope: usize,
}

impl Group {
    /// Adds `M_lj sums_j` to the channels of `matrix` that are there.
    #[inline]
    pub(crate) fn add_to(&self, matrix: &mut Matrix4<f64>, sums: &[f64; 4]) {
        let (from, into) = (self.mueller.as_slice(), matrix.as_mut_slice());
        if let Some((j, l)) = self.set.single() {
            let place = 4 * j + l;
            into[place] += from[place] * sums[j];
            return;
        }
        // by columns, one for each incident parameter
        for ((from, into), sum) in from.chunks_exact(4).zip(into.chunks_exact_mut(4)).zip(sums) {
            for (from, into) in from.iter().zip(into) {
                *into += from * sum;
            }
        }
    }
}

/// Matter at one encounter: for each channel its mutual autocorrelation `R^(j→l)`, and the number of its envelope.
///
/// Channels of one autocorrelation are held, and evaluated, once. An absent channel costs nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    groups: SmallVec<[Group; 1]>,
    set: ChannelSet,
}

impl Channels {
    /// Matter of one response and one autocorrelation.
    #[must_use]
    pub fn new(mueller: &Mueller, autocorrelation: Autocorrelation) -> Self {
        Self::default().with(mueller, autocorrelation, 0)
    }

    /// This matter and more of it: `R^(j→l) = mueller_lj · autocorrelation` over the envelope of that number.
    #[must_use]
    pub fn with(
        mut self,
        mueller: &Mueller,
        autocorrelation: Autocorrelation,
        envelope: usize,
    ) -> Self {
        let matrix = mueller.to_matrix();
        let same = self
            .groups
            .iter_mut()
            .find(|g| g.envelope == envelope && g.autocorrelation == autocorrelation);
        match same {
            Some(group) => {
                group.mueller += matrix;
                group.set = ChannelSet::of(&group.mueller.into());
            }
            None => self.groups.push(Group {
                mueller: matrix,
                set: ChannelSet::of(mueller),
                autocorrelation,
                envelope,
            }),
        }
        self.groups.retain(|group| !group.set.is_empty());
        self.set = self
            .groups
            .iter()
            .fold(ChannelSet::EMPTY, |set, group| set.union(group.set));
        self
    }

    /// The channels that are there.
    #[must_use]
    pub fn set(&self) -> ChannelSet {
        self.set
    }

    /// The mutual autocorrelation of channel `j → l` over one envelope; `None` where it vanishes.
    #[must_use]
    pub fn autocorrelation(&self, j: usize, l: usize, envelope: usize) -> Option<Autocorrelation> {
        self.groups
            .iter()
            .filter(|group| group.envelope == envelope && group.set.contains(j, l))
            .map(|group| group.autocorrelation.clone().scaled(group.mueller[(l, j)]))
            .reduce(|sum, more| sum.plus(&more))
    }

    /// The Mueller matrix `R^(j→l)(0)`: what the matter does to the total power, over all envelopes.
    #[must_use]
    pub fn mueller(&self) -> Mueller {
        let sum: Matrix4<f64> = self
            .groups
            .iter()
            .map(|group| group.mueller * group.autocorrelation.at_zero())
            .sum();
        sum.into()
    }

    pub(crate) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// One more than the largest number of an envelope.
    pub(crate) fn envelope_count(&self) -> usize {
        self.groups
            .iter()
            .map(|g| g.envelope + 1)
            .max()
            .unwrap_or(0)
    }
}
