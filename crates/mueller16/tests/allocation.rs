//! A transfer allocates nothing: the number of allocations of the thread stands still while it runs.
#![expect(unsafe_code, reason = "every global allocator is")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use mueller16::{Autocorrelation, Channels, GaussianTerm, Geometry, IncidentCoherence, Tolerance};
use nalgebra::{Matrix2, Matrix4, Vector3};
use stokes::{HermiteSeries, Mueller, Wavelength, mode_count};

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: everything is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `alloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = COUNT.get();
    work();
    COUNT.get() - before
}

#[test]
fn transfers_allocate_nothing() {
    let unit = |x: f64| Vector3::new(x, 0.0, (1.0 - x * x).sqrt());
    let green = Wavelength::from_metres(550e-9).unwrap();
    let geometry = Geometry::on_plane(unit(0.5), unit(-0.499), green).unwrap();
    let dense = Matrix4::from_fn(|l, j| 1.0 / (1.0 + l as f64 + 2.0 * j as f64));
    let family = |step: usize, count: u32| {
        let root = Matrix2::new(1.1, 0.4, -0.3, 0.8) * (1e-5 * (1.0 + step as f64));
        let terms = (1..=count).map(|m| GaussianTerm::centred(1.0, f64::from(m)));
        Autocorrelation::of_family(&root, terms).unwrap()
    };
    let shared = Channels::new(&Mueller::from(dense), family(0, 11));
    let mut different = Channels::default();
    for place in 0..16 {
        let mut one = Matrix4::zeros();
        one[place] = 1.0;
        different = different.with(&Mueller::from(one), family(place, 1), 0);
    }
    for order in [0, 4, 33] {
        let series = vec![0.1; mode_count(order)];
        let series = HermiteSeries::from_real_coefficients(&series).unwrap();
        let light = IncidentCoherence::new(Matrix2::new(7e4, -5e4, 2e4, 9e4), &series).unwrap();
        for channels in [&shared, &different] {
            let count = allocations(|| {
                channels.transfer(&geometry, &light).unwrap();
                let tolerance = Tolerance::ROUNDING;
                channels
                    .transfer_in::<f32>(&geometry, &light, tolerance)
                    .unwrap();
            });
            assert_eq!(count, 0, "order {order}");
        }
    }
    // what counts counts
    assert!(allocations(|| drop(vec![1.0; 5])) > 0);
}
