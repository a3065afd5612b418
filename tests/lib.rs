//! Shared by the end-to-end tests: small scenes in, Stokes images with their noise out; and the program itself.
//!
//! All random numbers have fixed seeds. Images are compared within the noise that their own variance channels state:
//! a difference fails beyond [`SIGMAS`] standard errors, which a right program exceeds with a probability below 1e-6
//! in each number that is looked at, plus round-off where that is stated.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use render::engine::{Job, Limits, Rendering, render};
use render::film::SpectralMode;
use render::image::{Colour, StokesImage};
use render::plan::Components;
use render::scene::{Document, Overrides, build, read, read_text};

/// Standard errors beyond which a difference is no noise: 6e-7 of normal numbers are.
pub const SIGMAS: f64 = 5.0;

/// How to render.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Samples a pixel.
    pub spp: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Wavelengths.
    pub mode: SpectralMode,
    /// Stokes vectors, or S0 alone by scalar transport.
    pub polarized: bool,
    /// Size of the film instead of the scene's.
    pub size: Option<[u32; 2]>,
    /// Crop window.
    pub crop: Option<[u32; 4]>,
    /// Size of emitter patches instead of the scene's.
    pub patch: Option<f32>,
}

impl Shot {
    /// So many samples of Stokes vectors at 550 nm, with seed 1.
    pub fn new(spp: u64) -> Self {
        Self {
            spp,
            seed: 1,
            mode: SpectralMode::Single(550.0),
            polarized: true,
            size: None,
            crop: None,
            patch: None,
        }
    }

    /// A job for the renderer.
    pub fn job(&self, document: &Document) -> Job {
        let overrides = Overrides {
            size: self.size,
            crop: self.crop,
        };
        let built = build(document, overrides).unwrap_or_else(|error| panic!("{error}"));
        let mut job = Job {
            polarized: self.polarized,
            samples: self.spp,
            seed: self.seed,
            ..Job::new(built, self.mode.clone())
        };
        job.plan.stokes = if self.polarized {
            Components::All
        } else {
            Components::Intensity
        };
        job.paths.patch = self.patch.unwrap_or(job.paths.patch);
        job
    }

    /// Renders a scene given as text.
    pub fn of_text(&self, text: &str) -> StokesImage {
        let document =
            read_text(text, Path::new("test.xml"), &[]).unwrap_or_else(|error| panic!("{error}"));
        self.of_document(&document)
    }

    /// Renders a scene of the `scenes` folder.
    pub fn of_scene(&self, name: &str) -> StokesImage {
        let path = repository().join("scenes").join(name).join("scene.xml");
        self.of_document(&read(&path, &[]).unwrap_or_else(|error| panic!("{error}")))
    }

    /// Renders a scene.
    pub fn of_document(&self, document: &Document) -> StokesImage {
        let job = self.job(document);
        image_of(
            &job,
            &render(&job, Limits::default(), &AtomicBool::new(false), |_| ()),
        )
    }
}

/// The image of a rendering, with variances.
pub fn image_of(job: &Job, rendering: &Rendering) -> StokesImage {
    assert_eq!(rendering.rejected, 0, "samples that are not finite");
    let [width, height] = job.film.crop_size.map(|n| n as usize);
    let colour = match &job.mode {
        SpectralMode::Single(wavelength) => Colour::Mono {
            wavelength_nm: Some(*wavelength),
        },
        SpectralMode::Bands { .. } => Colour::Bands {
            wavelengths_nm: job.mode.band_centres(),
        },
        SpectralMode::Rgb => Colour::Rgb,
    };
    let mut image = StokesImage::new(width, height, rendering.components(), colour);
    let (means, variances) = rendering.image();
    image.stokes = means;
    image.variance = Some(variances);
    image
}

/// A scene file: paths of at most `depth`, a square one-pixel camera of `fov` degrees, and what it sees.
///
/// `lookat` are the attributes of the camera's placement.
pub fn scene(depth: i64, lookat: &str, fov: f64, content: &str) -> String {
    film_scene(depth, lookat, fov, [1, 1], content)
}

/// The same with a film of several pixels.
pub fn film_scene(
    depth: i64,
    lookat: &str,
    fov: f64,
    [width, height]: [u32; 2],
    content: &str,
) -> String {
    format!(
        "<scene version='3.0.0'>
            <integrator type='path'>
                <integer name='max_depth' value='{depth}'/><integer name='rr_depth' value='1000000'/>
            </integrator>
            <sensor type='perspective'>
                <float name='fov' value='{fov}'/>
                <transform name='to_world'><lookat {lookat}/></transform>
                <film type='hdrfilm'>
                    <integer name='width' value='{width}'/><integer name='height' value='{height}'/>
                    <rfilter type='box'/>
                </film>
            </sensor>
            {content}
        </scene>"
    )
}

/// Mean Stokes vector of an image in one colour, and the standard error of each component.
pub fn mean(image: &StokesImage, colour: usize) -> ([f64; 4], [f64; 4]) {
    let count = (image.width * image.height) as f64;
    let (mut sum, mut variance) = ([0.0; 4], [0.0; 4]);
    for y in 0..image.height {
        for x in 0..image.width {
            let (s, v) = pixel(image, x, y, colour);
            for k in 0..4 {
                sum[k] += s[k] / count;
                variance[k] += (v[k] / count).powi(2);
            }
        }
    }
    (sum, variance.map(f64::sqrt))
}

/// Stokes vector of a pixel, and the standard error of each component.
pub fn pixel(image: &StokesImage, x: usize, y: usize, colour: usize) -> ([f64; 4], [f64; 4]) {
    let variance = image
        .variance_at(x, y, colour)
        .expect("renderings have variances");
    (image.stokes_at(x, y, colour), variance.map(f64::sqrt))
}

/// Checks that a Stokes vector is the expected one within its noise and `round_off`.
pub fn assert_stokes(
    what: &str,
    (found, error): ([f64; 4], [f64; 4]),
    expected: [f64; 4],
    round_off: f64,
) {
    for k in 0..4 {
        assert!(
            (found[k] - expected[k]).abs() <= SIGMAS * error[k] + round_off,
            "{what}: S{k} is off: found {found:.6?} ± {error:.7?}, expected {expected:.6?}"
        );
    }
}

/// The folder of the repository.
pub fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Makes the mesh of `scenes/big_mesh`, which is too large to commit, where it is missing; `false` without Python.
pub fn make_big_mesh() -> bool {
    let scenes = repository().join("scenes");
    if scenes.join("big_mesh/displaced_sphere_200k.obj").is_file() {
        return true;
    }
    match Command::new("python3")
        .arg(scenes.join("make_meshes.py"))
        .status()
    {
        Ok(status) => {
            assert!(status.success(), "scenes/make_meshes.py failed");
            true
        }
        Err(_) => false,
    }
}

/// The `brewster` program with the same optimisation as the tests, built once.
pub fn brewster() -> Command {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    let program = PROGRAM.get_or_init(|| {
        let build = escargot::CargoBuild::new()
            .manifest_path(repository().join("Cargo.toml"))
            .package("render")
            .bin("brewster");
        let build = if cfg!(debug_assertions) {
            build
        } else {
            build.release()
        };
        let run = build.run().unwrap_or_else(|error| panic!("{error}"));
        run.path().to_owned()
    });
    Command::new(program)
}

/// The results in an answer of `brewster eval`, by the ids of their cases.
pub fn results_by_id(answer: &serde_json::Value) -> BTreeMap<String, &serde_json::Value> {
    let mut results = BTreeMap::new();
    for case in answer["cases"].as_array().into_iter().flatten() {
        let id = case["id"].as_str().unwrap_or_default().to_owned();
        let before = results.insert(id, &case["result"]);
        assert!(before.is_none(), "an id for the second time: {case}");
    }
    results
}
