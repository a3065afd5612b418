//! What matter scatters to one side of a lit surface: populations of one autocorrelation, each a sum of Gaussians.

use std::f64::consts::TAU;

use mueller16::Autocorrelation;
use nalgebra::{Matrix2, Matrix4, Vector2};

use super::lobes::Lobe;

/// Populations that differ in their matrix alone: one matrix, one autocorrelation, one envelope.
#[derive(Clone, Debug)]
struct Group {
    matrix: Matrix4<f64>,
    envelope: usize,
    autocorrelation: Autocorrelation,
    lobes: Vec<Lobe>,
}

impl Group {
    fn new(matrix: Matrix4<f64>, autocorrelation: Autocorrelation, envelope: usize) -> Self {
        let mut lobes = vec![];
        for family in autocorrelation.families() {
            for term in family.terms() {
                Lobe::add(&mut lobes, family, term);
            }
        }
        Self {
            matrix,
            envelope,
            autocorrelation,
            lobes,
        }
    }

    /// By which its lobes are chosen.
    #[inline]
    fn chance(&self, intensities: &[f64]) -> f64 {
        self.matrix.m11.abs() * intensities[self.envelope]
    }
}

/// All that decays on one side.
#[derive(Clone, Debug, Default)]
pub(super) struct Side {
    groups: Vec<Group>,
}

/// What a side answers for one pair of directions.
pub(super) struct Answer {
    /// `(1/λ²) I Σ M F{R γ}(φ_t)`, 1/sr.
    pub(super) matrix: Matrix4<f64>,
    /// Density per steradian of the drawn directions, times the sum of all shares.
    pub(super) density: f64,
}

impl Side {
    /// Adds what decays of a population.
    pub(super) fn add(
        &mut self,
        matrix: &Matrix4<f64>,
        autocorrelation: Autocorrelation,
        envelope: usize,
    ) {
        let same = |group: &&mut Group| {
            group.envelope == envelope && group.autocorrelation == autocorrelation
        };
        match self.groups.iter_mut().find(same) {
            Some(group) => group.matrix += matrix,
            None => self
                .groups
                .push(Group::new(*matrix, autocorrelation, envelope)),
        }
    }

    /// Whether nothing decays here.
    pub(super) fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Least standard deviation of a lobe, rad/m.
    pub(super) fn narrowest(&self) -> f64 {
        let lobes = self.groups.iter().flat_map(|group| &group.lobes);
        lobes.map(Lobe::narrowest).fold(f64::INFINITY, f64::min)
    }

    /// Its lobes with their shares of the choice. Of a lobe that is taken off others, its modulus: what is left is below
    /// the sum.
    pub(super) fn shares(&self, intensities: &[f64]) -> impl Iterator<Item = (f64, &Lobe)> {
        self.groups.iter().flat_map(move |group| {
            let chance = group.chance(intensities);
            group
                .lobes
                .iter()
                .map(move |lobe| (chance * lobe.weight().abs(), lobe))
        })
    }

    /// What light of wavenumber k does whose tangential wave vector `φ` is; `light` is the root V of the covariance VᵀV
    /// of its directions in φ, `None` for a plane wave. `cos` belongs to the direction toward the light.
    pub(super) fn answer(
        &self,
        phi: &Vector2<f64>,
        light: Option<&Matrix2<f64>>,
        cos: f64,
        k: f64,
        intensities: &[f64],
    ) -> Answer {
        let (mut matrix, mut density) = (Matrix4::zeros(), 0.0);
        for group in &self.groups {
            let (mut sum, mut drawn) = (0.0, 0.0);
            for lobe in &group.lobes {
                let (plane, lit) = lobe.values(phi, light);
                sum += lobe.weight() * lit;
                drawn += lobe.weight().abs() * lobe.density(plane, cos, k);
            }
            matrix += group.matrix * (sum * intensities[group.envelope]);
            density += group.chance(intensities) * drawn;
        }
        // 1/λ² times 2π of each transform
        matrix *= k * k / TAU;
        Answer { matrix, density }
    }
}
