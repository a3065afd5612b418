//! The image behind an analyzer, with what is known about its noise.

use super::Analyzer;
use crate::engine::Rendering;
use crate::image::StokesImage;
use crate::output::ImageError;

/// The light in front of the analyzers: a Stokes image, and the sums it came from where it has just been rendered.
#[derive(Clone, Copy, Debug)]
pub struct Incident<'a> {
    image: &'a StokesImage,
    film: Option<&'a Rendering>,
}

impl<'a> Incident<'a> {
    /// The light of an image; `film` makes its variances exact, and must be what `image` was made of.
    ///
    /// # Errors
    /// The image has S0 only.
    pub fn new(image: &'a StokesImage, film: Option<&'a Rendering>) -> Result<Self, ImageError> {
        if let Some(problem) = image.inconsistency() {
            return Err(ImageError::Request(problem));
        }
        if image.components != 4 {
            return Err(ImageError::Request(
                "the image has S0 only, an analyzer needs S1 to S3; render it without --unpolarized"
                    .to_owned(),
            ));
        }
        Ok(Self {
            image,
            film: film.filter(|film| film.sums_products()),
        })
    }

    /// The image itself.
    pub fn image(&self) -> &'a StokesImage {
        self.image
    }

    /// What the variances behind an analyzer are, in words.
    pub fn variance(&self) -> &'static str {
        match (&self.image.variance, self.film) {
            (None, _) => "none",
            (_, Some(_)) => "of the samples behind the analyzer",
            (_, None) => {
                "upper bound (sum |a_k| sigma_k)^2: the image does not hold the covariances of its components"
            }
        }
    }

    /// The Stokes image behind an analyzer.
    pub fn behind(&self, analyzer: &Analyzer) -> StokesImage {
        let rows = analyzer.rows();
        self.through(&analyzer.description, 4, |_, _| &rows)
    }

    /// The intensities of detectors whose sensitivity to S0 … S3 depends on the pixel.
    pub(super) fn detected(
        &self,
        description: &str,
        row: impl Fn(usize, usize) -> [f64; 4],
    ) -> StokesImage {
        let rows: Vec<[[f64; 4]; 1]> = (0..self.image.height)
            .flat_map(|y| (0..self.image.width).map(move |x| (x, y)))
            .map(|(x, y)| [row(x, y)])
            .collect();
        self.through(description, 1, |x, y| &rows[y * self.image.width + x])
    }

    /// `rows` times the Stokes vector of each pixel.
    fn through<'r>(
        &self,
        description: &str,
        components: usize,
        rows: impl Fn(usize, usize) -> &'r [[f64; 4]],
    ) -> StokesImage {
        let image = self.image;
        let mut out = StokesImage::new(image.width, image.height, components, image.colour.clone());
        let mut variances = out.stokes.clone();
        for y in 0..image.height {
            for x in 0..image.width {
                for colour in 0..image.colour.count() {
                    let s = image.stokes_at(x, y, colour);
                    for (component, row) in rows(x, y).iter().enumerate() {
                        let at = out.index(x, y, component, colour);
                        out.stokes[at] = row.iter().zip(s).map(|(a, s)| a * s).sum::<f64>() as f32;
                        variances[at] = self.variance_of(x, y, colour, row) as f32;
                    }
                }
            }
        }
        out.variance = image.variance.is_some().then_some(variances);
        out.metadata = self.metadata(description);
        out
    }

    /// Variance of a weighted sum of the components of a pixel; where covariances are unknown, the greatest it can be.
    fn variance_of(&self, x: usize, y: usize, colour: usize, weights: &[f64; 4]) -> f64 {
        let exact = self
            .film
            .and_then(|film| film.variance_of(x as u32, y as u32, colour, weights));
        exact.unwrap_or_else(|| {
            let variances = self.image.variance_at(x, y, colour).unwrap_or_default();
            let sum: f64 = weights
                .iter()
                .zip(variances)
                .map(|(a, v)| a.abs() * v.sqrt())
                .sum();
            sum * sum
        })
    }

    fn metadata(&self, description: &str) -> std::collections::BTreeMap<String, String> {
        let mut metadata = self.image.metadata.clone();
        let before = metadata.remove("analyzer");
        metadata.insert(
            "analyzer".to_owned(),
            before.map_or_else(
                || description.to_owned(),
                |before| format!("{before}, then {description}"),
            ),
        );
        metadata.insert("analyzerVariance".to_owned(), self.variance().to_owned());
        metadata
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Colour;

    /// One pixel of two bands with variances.
    fn image() -> StokesImage {
        let mut image = StokesImage::new(
            1,
            1,
            4,
            Colour::Bands {
                wavelengths_nm: vec![500.0, 600.0],
            },
        );
        image.stokes = vec![1.0, 2.0, 0.5, -1.0, 0.25, 0.5, -0.125, 1.0];
        image.variance = Some(vec![0.04, 0.01, 0.01, 0.0, 0.0, 0.0, 0.09, 0.01]);
        image
    }

    fn assert_near(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() < 1e-6,
            "{found}, expected {expected}"
        );
    }

    #[test]
    fn malus_law_holds_in_every_band() {
        let image = image();
        let behind = Incident::new(&image, None)
            .unwrap()
            .behind(&Analyzer::linear(30.0));
        let (c, s) = (0.5, 3f64.sqrt() / 2.0);
        for (colour, [s0, s1, s2]) in [[1.0, 0.5, 0.25], [2.0, -1.0, 0.5]].into_iter().enumerate() {
            let intensity = 0.5 * (s0 + c * s1 + s * s2);
            let found = behind.stokes_at(0, 0, colour);
            for (found, expected) in found.into_iter().zip([1.0, c, s, 0.0]) {
                assert_near(found, expected * intensity);
            }
        }
    }

    #[test]
    fn the_variance_of_a_finished_image_is_an_upper_bound() {
        let image = image();
        let incident = Incident::new(&image, None).unwrap();
        let behind = incident.behind(&Analyzer::circular(true));
        // ½ (S0 − S3): half of 0.2 + 0.3, half of 0.1 + 0.1
        assert_near(behind.variance_at(0, 0, 0).unwrap()[0], 0.25 * 0.25);
        assert_near(behind.variance_at(0, 0, 1).unwrap()[0], 0.01);
        assert!(behind.metadata["analyzerVariance"].starts_with("upper bound"));
    }

    #[test]
    fn analyzers_behind_each_other_are_told_in_order() {
        let image = image();
        let first = Incident::new(&image, None)
            .unwrap()
            .behind(&Analyzer::circular(false));
        let second = Incident::new(&first, None)
            .unwrap()
            .behind(&Analyzer::linear(90.0));
        let told = &second.metadata["analyzer"];
        assert!(
            told.starts_with("right circular") && told.contains(", then linear"),
            "{told}"
        );
        // ½ (S0 + S3), and half of that
        assert_near(second.stokes_at(0, 0, 0)[0], 0.25 * (1.0 - 0.125));
    }

    #[test]
    fn intensity_alone_has_no_polarization_to_analyze() {
        let image = StokesImage::new(1, 1, 1, Colour::Rgb);
        let error = Incident::new(&image, None).unwrap_err().to_string();
        assert!(error.contains("needs S1 to S3"), "{error}");
    }
}
