//! Compares two Stokes images, component by component, with their noise taken into account.
//!
//! For each of S0 to S3, with d = test − reference over pixels and colours:
//!
//! ```text
//! rmse      √mean d²                                        noise of both images included
//! excess    √max(0, mean d² − mean σ_t² − mean σ_r²)        what noise does not explain
//! mean      mean d;  t = mean / hypot(std d / √pixels, floor · mean S0)
//! z>4       share of |d| > 4 √(σ_t² + σ_r² + ε²),           ε = floor · (mean S0 + |reference|)
//! block>5   share of B×B blocks whose mean d is off by more than 5 of its own standard errors
//! max       greatest |d|
//! ```
//!
//! Colours of a pixel are correlated, so t counts pixels, not numbers. `floor` keeps round-off of 32-bit files from looking
//! like a difference.

use crate::image::StokesImage;

/// Round-off and block size of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Side of a block in pixels, 2 or more.
    pub block: usize,
    /// Relative round-off added to the standard errors.
    pub floor: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            block: 8,
            floor: 1e-6,
        }
    }
}

/// How one Stokes component of the test image differs from the reference.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Row {
    /// `S0` to `S3`.
    pub component: String,
    /// Root mean square difference.
    pub rmse: f64,
    /// Mean signed difference.
    pub mean: f64,
    /// Greatest absolute difference.
    pub max_abs: f64,
    /// `mean` in units of its own standard error.
    pub mean_t: f64,
    /// Share of numbers more than 4 standard errors off; needs standard errors of the test image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z4_frac: Option<f64>,
    /// Greatest difference in standard errors; needs those of the test image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_max: Option<f64>,
    /// Root mean square of the differences in standard errors, each cut at 50; 1 where noise explains all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_rms: Option<f64>,
    /// Root mean square difference that noise does not explain; needs standard errors of the test image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excess_rmse: Option<f64>,
    /// Share of blocks off by more than 5 of their own standard errors.
    pub block5_frac: f64,
}

/// Fewer renders or blocks of samples than this tell the variance of a pixel poorly.
const FEW: u64 = 16;

/// Numbers of a Stokes image in double precision, as the comparison reads them.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Stokes components: 4 or 1.
    pub components: usize,
    /// Numbers per component.
    pub colours: usize,
    /// `[row][column][component][colour]`.
    pub values: Vec<f64>,
}

impl Field {
    /// The Stokes parameters of an image.
    pub fn stokes(image: &StokesImage) -> Self {
        Self::new(image, image.stokes.iter().map(|&v| f64::from(v)).collect())
    }

    /// The standard errors of an image, where it has variances; from few blocks of samples as in [`mean_of_seeds`].
    pub fn standard_errors(image: &StokesImage) -> Option<Self> {
        let variance = image.variance.as_ref()?;
        let variance = variance.iter().map(|&v| f64::from(v).max(0.0)).collect();
        let mut field = Self::new(image, variance);
        if image.blocks().is_some_and(|blocks| blocks < FEW) {
            field.values = raised_to_neighbourhood(&field);
        }
        field.values.iter_mut().for_each(|v| *v = v.sqrt());
        Some(field)
    }

    fn new(image: &StokesImage, values: Vec<f64>) -> Self {
        Self {
            width: image.width,
            height: image.height,
            components: image.components,
            colours: image.colour.count(),
            values,
        }
    }

    /// Brings a field to the shape of the reference: three equal colours become one where the reference has one, and S1 to S3
    /// are dropped where it holds S0 alone.
    ///
    /// # Errors
    /// Sizes or colours do not fit; `what` names the field in the text.
    pub fn matched(mut self, reference: &Self, what: &str) -> Result<Self, String> {
        if (self.width, self.height) != (reference.width, reference.height) {
            let (w, h) = (reference.width, reference.height);
            return Err(format!(
                "{what} is {}x{}, the reference {w}x{h}, expected the same size",
                self.width, self.height
            ));
        }
        if self.components > reference.components {
            self = self.first_component();
        }
        if self.components < reference.components {
            return Err(format!(
                "{what} has S0 only, the reference S0 to S3; render it polarized, or compare against S0 alone"
            ));
        }
        if self.colours == reference.colours {
            return Ok(self);
        }
        if reference.colours != 1 {
            return Err(format!(
                "{what} has {} colours, the reference {}, expected the same",
                self.colours, reference.colours
            ));
        }
        let greatest = self.values.iter().fold(1e-12, |m: f64, v| m.max(v.abs()));
        if self
            .values
            .chunks(self.colours)
            .any(|c| c.iter().any(|v| (v - c[0]).abs() > 1e-5 * greatest))
        {
            return Err(format!(
                "{what} has {} different colours, the reference is monochromatic",
                self.colours
            ));
        }
        self.values = self.values.iter().step_by(self.colours).copied().collect();
        self.colours = 1;
        Ok(self)
    }

    /// The field of S0 alone.
    pub fn first_component(&self) -> Self {
        let step = self.components * self.colours;
        let values = self
            .values
            .chunks(step)
            .flat_map(|pixel| &pixel[..self.colours])
            .copied()
            .collect();
        Self {
            components: 1,
            values,
            ..*self
        }
    }

    /// Where component k and colour c of pixel (x, y) is.
    fn at(&self, x: usize, y: usize, k: usize, c: usize) -> usize {
        ((y * self.width + x) * self.components + k) * self.colours + c
    }

    /// All numbers of one component, pixel by pixel.
    fn component(&self, k: usize) -> Vec<f64> {
        let step = self.components * self.colours;
        self.values
            .chunks(step)
            .flat_map(|pixel| &pixel[k * self.colours..(k + 1) * self.colours])
            .copied()
            .collect()
    }

    fn map(&self, values: Vec<f64>) -> Self {
        Self { values, ..*self }
    }
}

/// Mean of several renders of one scene, and the standard error of that mean.
///
/// Few renders give a poor estimate per pixel: each variance is then raised to the mean of its 5×5 neighbourhood where that
/// is greater. `renders` holds two fields or more of one shape.
pub fn mean_of_seeds(renders: &[Field]) -> (Field, Field) {
    let n = renders.len() as f64;
    let first = &renders[0];
    let moments = |i: usize| {
        let mean = renders.iter().map(|r| r.values[i]).sum::<f64>() / n;
        let variance = renders
            .iter()
            .map(|r| (r.values[i] - mean).powi(2))
            .sum::<f64>()
            / (n - 1.0);
        (mean, variance / n)
    };
    let (mean, mut variance): (Vec<f64>, Vec<f64>) = (0..first.values.len()).map(moments).unzip();
    if (renders.len() as u64) < FEW {
        variance = raised_to_neighbourhood(&first.map(variance));
    }
    (
        first.map(mean),
        first.map(variance.into_iter().map(f64::sqrt).collect()),
    )
}

fn raised_to_neighbourhood(variance: &Field) -> Vec<f64> {
    let mut out = variance.values.clone();
    let clamped = |i: usize, d: usize, n: usize| (i + d).saturating_sub(2).min(n - 1);
    for y in 0..variance.height {
        for x in 0..variance.width {
            for k in 0..variance.components {
                for c in 0..variance.colours {
                    let near = |i: usize| {
                        (
                            clamped(x, i % 5, variance.width),
                            clamped(y, i / 5, variance.height),
                        )
                    };
                    let sum: f64 = (0..25)
                        .map(near)
                        .map(|(x, y)| variance.values[variance.at(x, y, k, c)])
                        .sum();
                    let value = &mut out[variance.at(x, y, k, c)];
                    *value = value.max(sum / 25.0);
                }
            }
        }
    }
    out
}

/// Compares a test image with a reference of the same shape; returns the rows and the mean |S0| of the reference.
///
/// # Errors
/// Values are not finite, the floor is negative, or the block is larger than the image or smaller than 2.
pub fn compare(
    test: &Field,
    reference: &Field,
    test_error: Option<&Field>,
    reference_error: Option<&Field>,
    settings: &Settings,
) -> Result<(Vec<Row>, f64), String> {
    for (name, field) in [("test image", test), ("reference", reference)] {
        let bad = field.values.iter().filter(|v| !v.is_finite()).count();
        if bad > 0 {
            return Err(format!(
                "{bad} values of the {name} are not finite, expected none"
            ));
        }
    }
    if !(settings.floor.is_finite() && settings.floor >= 0.0) {
        return Err(format!(
            "--floor is {}, expected a number from 0 upwards",
            settings.floor
        ));
    }
    let smaller = reference.width.min(reference.height);
    if settings.block < 2 || settings.block > smaller {
        return Err(format!(
            "--block is {}, expected 2 to {smaller} for an image of {}x{}",
            settings.block, reference.width, reference.height
        ));
    }
    let scale = mean(reference.component(0).iter().map(|v| v.abs())).max(1e-12);
    let row = |k: usize| {
        let r = reference.component(k);
        let sr = reference_error.map_or_else(|| vec![0.0; r.len()], |e| e.component(k));
        Differences {
            d: test
                .component(k)
                .iter()
                .zip(&r)
                .map(|(t, r)| t - r)
                .collect(),
            st: test_error.map(|e| e.component(k)),
            sr,
            eps: r
                .iter()
                .map(|r| settings.floor * (scale + r.abs()))
                .collect(),
            width: reference.width,
            height: reference.height,
            colours: reference.colours,
        }
        .row(k, settings, scale)
    };
    Ok(((0..reference.components).map(row).collect(), scale))
}

/// Everything about one component.
struct Differences {
    d: Vec<f64>,
    st: Option<Vec<f64>>,
    sr: Vec<f64>,
    eps: Vec<f64>,
    width: usize,
    height: usize,
    colours: usize,
}

impl Differences {
    fn row(&self, component: usize, settings: &Settings, scale: f64) -> Row {
        let mean_d = mean(self.d.iter().copied());
        let mse = mean(self.d.iter().map(|d| d * d));
        let std = mean(self.d.iter().map(|d| (d - mean_d).powi(2))).sqrt();
        let pixels = (self.width * self.height) as f64;
        let mut row = Row {
            component: format!("S{component}"),
            rmse: mse.sqrt(),
            mean: mean_d,
            max_abs: self.d.iter().fold(0.0, |m: f64, d| m.max(d.abs())),
            mean_t: mean_d / (std / pixels.sqrt()).hypot(settings.floor * scale),
            z4_frac: None,
            z_max: None,
            z_rms: None,
            excess_rmse: None,
            block5_frac: self.block_fraction(settings.block),
        };
        if let Some(st) = &self.st {
            let z: Vec<f64> = (0..self.d.len())
                .map(|i| {
                    self.d[i].abs()
                        / (st[i].powi(2) + self.sr[i].powi(2) + self.eps[i].powi(2)).sqrt()
                })
                .collect();
            let noise = mean(st.iter().map(|s| s * s)) + mean(self.sr.iter().map(|s| s * s));
            row.z4_frac = Some(mean(z.iter().map(|&z| f64::from(u8::from(z > 4.0)))));
            row.z_max = Some(z.iter().copied().fold(0.0, f64::max));
            row.z_rms = Some(mean(z.iter().map(|z| z.min(50.0).powi(2))).sqrt());
            row.excess_rmse = Some((mse - noise).max(0.0).sqrt());
        }
        row
    }

    /// Share of blocks, over all colours, whose mean difference exceeds five of its standard errors.
    fn block_fraction(&self, block: usize) -> f64 {
        let (columns, rows) = (self.width / block, self.height / block);
        let mut off = 0_usize;
        for colour in 0..self.colours {
            for corner in 0..columns * rows {
                let (x, y) = (corner % columns * block, corner / columns * block);
                let pixels =
                    (0..block * block).map(|i| (y + i / block) * self.width + x + i % block);
                off += usize::from(
                    self.block_is_off(
                        &pixels
                            .map(|p| p * self.colours + colour)
                            .collect::<Vec<_>>(),
                    ),
                );
            }
        }
        off as f64 / (self.colours * columns * rows) as f64
    }

    fn block_is_off(&self, pixels: &[usize]) -> bool {
        let n = pixels.len() as f64;
        let average = mean(pixels.iter().map(|&p| self.d[p]));
        let scatter = pixels
            .iter()
            .map(|&p| (self.d[p] - average).powi(2))
            .sum::<f64>()
            / (n - 1.0);
        let reference = pixels.iter().map(|&p| self.sr[p].powi(2)).sum::<f64>() / (n * n);
        let floor = mean(pixels.iter().map(|&p| self.eps[p])).powi(2);
        average.abs() / (scatter / n + reference + floor).sqrt() > 5.0
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
