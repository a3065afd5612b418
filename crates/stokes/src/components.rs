//! The four series of a generalized Stokes vector, held as sparsely as the light is.
//!
//! A shared mode vector is stored once and evaluated once, an absent component neither, and a series of order 0 is one
//! number ([`HermiteSeries`]). Everything that reads four parameters goes through [`Components::map`].

use crate::beam::LightError;
use crate::series::HermiteSeries;
use crate::vector::StokesVector;

/// The four series of a generalized Stokes vector, as sparse as the light is.
#[derive(Clone, Debug, PartialEq)]
pub enum Components {
    /// One series for all four: `C_j = S_j · modes`. This is what locally stationary matter with one envelope
    /// scatters, and what a source radiates whose polarization does not depend on place.
    Shared {
        /// The common series.
        modes: HermiteSeries,
        /// The four amplitudes.
        stokes: StokesVector,
    },
    /// A series for each component; `None` where a component vanishes.
    Separate([Option<HermiteSeries>; 4]),
}

impl Components {
    /// Highest total order of any component.
    #[must_use]
    pub fn order(&self) -> usize {
        match self {
            Self::Shared { modes, .. } => modes.order(),
            Self::Separate(series) => series
                .iter()
                .flatten()
                .map(HermiteSeries::order)
                .max()
                .unwrap_or(0),
        }
    }

    /// The series of component `j`, `None` where it vanishes.
    ///
    /// # Panics
    ///
    /// When `j` is not below 4.
    #[must_use]
    pub fn series(&self, j: usize) -> Option<HermiteSeries> {
        match self {
            Self::Shared { modes, stokes } => {
                let amplitude = stokes.to_array()[j];
                (amplitude != 0.0).then(|| modes.scaled(amplitude))
            }
            Self::Separate(series) => series[j].clone(),
        }
    }

    /// An error if an amplitude or a coefficient is not a finite number.
    pub(crate) fn finite(&self) -> Result<(), LightError> {
        match self {
            Self::Shared { modes, stokes } => {
                for (component, value) in stokes.to_array().into_iter().enumerate() {
                    if !value.is_finite() {
                        return Err(LightError::NotFinite { component, value });
                    }
                }
                modes.finite()?;
            }
            Self::Separate(series) => {
                series
                    .iter()
                    .flatten()
                    .try_for_each(HermiteSeries::finite)?;
            }
        }
        Ok(())
    }

    /// Four numbers from four series: each series is evaluated once.
    pub(crate) fn map<T>(&self, value: impl Fn(&HermiteSeries) -> T) -> [T; 4]
    where
        T: Copy + Default + std::ops::Mul<f64, Output = T>,
    {
        match self {
            Self::Shared { modes, stokes } => {
                let common = value(modes);
                stokes.to_array().map(|amplitude| common * amplitude)
            }
            Self::Separate(series) => {
                std::array::from_fn(|j| series[j].as_ref().map_or_else(T::default, &value))
            }
        }
    }

    /// The same components, each series changed by a linear map that does not depend on the component, and the sum
    /// of the squares of what the map reports as lost.
    pub(crate) fn map_series(
        &self,
        change: impl Fn(&HermiteSeries) -> (HermiteSeries, f64),
    ) -> (Self, f64) {
        match self {
            Self::Shared { modes, stokes } => {
                let (modes, lost) = change(modes);
                let stokes = *stokes;
                let lost = lost * stokes.to_vector().norm();
                (Self::Shared { modes, stokes }, lost)
            }
            Self::Separate(series) => {
                let changed = series.each_ref().map(|series| series.as_ref().map(&change));
                let lost = changed
                    .iter()
                    .flatten()
                    .map(|(_, lost)| lost * lost)
                    .sum::<f64>();
                (
                    Self::Separate(changed.map(|pair| pair.map(|(series, _)| series))),
                    lost.sqrt(),
                )
            }
        }
    }

    /// The L² norm of the four functions together.
    pub(crate) fn norm(&self) -> f64 {
        match self {
            Self::Shared { modes, stokes } => modes.norm() * stokes.to_vector().norm(),
            Self::Separate(series) => series
                .iter()
                .flatten()
                .map(|series| series.norm().powi(2))
                .sum::<f64>()
                .sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, GeneralizedStokes, ShapeMatrix, Wavelength};
    use nalgebra::{Matrix2, Vector2, Vector3};
    use std::cell::Cell;

    fn series(real: &[f64]) -> HermiteSeries {
        HermiteSeries::from_real_coefficients(real).unwrap()
    }

    /// The four numbers, and how many series were evaluated for them.
    fn counted(components: &Components) -> ([f64; 4], usize) {
        let evaluated = Cell::new(0);
        let values = components.map(|series| {
            evaluated.set(evaluated.get() + 1);
            series.real_sum(&Vector2::new(0.3, -0.2))
        });
        (values, evaluated.get())
    }

    /// How many series a change of shape, a truncation or the like works on.
    fn changed(components: &Components) -> (Components, usize) {
        let done = Cell::new(0);
        let (result, _) = components.map_series(|series| {
            done.set(done.get() + 1);
            series.truncated(1)
        });
        (result, done.get())
    }

    #[test]
    fn a_shared_mode_vector_is_evaluated_once() {
        let modes = series(&[1.0, 0.2, -0.1]);
        let stokes = StokesVector::new(2.0, 0.5, 0.0, -1.0);
        let once = modes.real_sum(&Vector2::new(0.3, -0.2));
        let shared = Components::Shared { modes, stokes };
        let (values, evaluated) = counted(&shared);
        assert_eq!(evaluated, 1);
        assert_eq!(values, stokes.to_array().map(|amplitude| amplitude * once));
        assert_eq!(changed(&shared).1, 1);
        // the same light written out costs three, since S2 vanishes
        let separate = Components::Separate(std::array::from_fn(|j| shared.series(j)));
        assert_eq!(counted(&separate).1, 3);
    }

    #[test]
    fn an_absent_component_is_not_evaluated() {
        for present in 0..16 {
            let here = |j: usize| present >> j & 1 == 1;
            let components = Components::Separate(std::array::from_fn(|j| {
                here(j).then(|| series(&[1.0, 0.2, -0.1]))
            }));
            let expected = (0..4).filter(|j| here(*j)).count();
            let (values, evaluated) = counted(&components);
            assert_eq!(evaluated, expected);
            assert!((0..4).all(|j| (values[j] != 0.0) == here(j)));
            let (after, done) = changed(&components);
            assert_eq!(done, expected);
            assert!((0..4).all(|j| after.series(j).is_some() == here(j)));
        }
    }

    #[test]
    fn light_of_order_0_owns_no_memory() {
        let light = |components| {
            GeneralizedStokes::new(
                components,
                ShapeMatrix::from_root(&Matrix2::from_diagonal_element(1e-3)).unwrap(),
                Frame::with_x_along(Vector3::z(), Vector3::x()).unwrap(),
                Wavelength::from_metres(500e-9).unwrap(),
                1.0,
            )
            .unwrap()
        };
        let spilled = |light: &GeneralizedStokes| match light.components() {
            Components::Shared { modes, .. } => modes.is_on_the_heap(),
            Components::Separate(series) => {
                series.iter().flatten().any(HermiteSeries::is_on_the_heap)
            }
        };
        let modes = HermiteSeries::fundamental(1.0);
        let stokes = StokesVector::new(2.0, 0.5, 0.2, -1.0);
        let shared = Components::Shared { modes, stokes };
        let separate = Components::Separate(std::array::from_fn(|j| shared.series(j)));
        for components in [shared, separate] {
            let light = light(components);
            let turned = light.in_frame(light.frame().turned(0.3)).unwrap();
            for light in [
                &light,
                &turned,
                &light.plus(&light).unwrap(),
                &light.scaled(2.0).unwrap(),
                &light.truncated(0).0,
                &light.clone().propagated_to(5.0).unwrap(),
            ] {
                assert!(!spilled(light));
            }
        }
        // the question is not idle
        assert!(series(&[1.0, 0.2, -0.1]).is_on_the_heap());
        assert!(!series(&[1.0, 0.2, -0.1]).truncated(0).0.is_on_the_heap());
    }
}
