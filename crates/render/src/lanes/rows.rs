//! Where numbers of many paths wait for lanes to take them: a row a quantity, a column a path.

use super::{Bits, MOST, Mask, Real, V3};

/// Most paths.
pub const COLUMNS: usize = 256;

/// Lanes beyond the last path have room to be written; and rows that are a power of two long would all share the same
/// few lines of a cache.
const LENGTH: usize = COLUMNS + 2 * MOST;

/// `N` rows of numbers.
#[derive(Clone, Debug)]
pub struct Rows<const N: usize>(Box<[[f32; LENGTH]; N]>);

/// From which columns lanes read.
#[derive(Clone, Copy, Debug)]
pub enum Columns<R: Real> {
    /// From this one on.
    From(usize),
    /// Each from its own.
    Each(R::B),
}

impl<R: Real> Columns<R> {
    /// Those that lanes name.
    #[inline(always)]
    pub fn named(columns: R::B) -> Self {
        let first = columns.lanes()[0];
        let following = R::B::from_fn(|lane| first.wrapping_add(lane as u32));
        if R::same(columns, following).bits() == R::everywhere().bits() {
            return Self::From(first as usize);
        }
        Self::Each(columns)
    }
    /// Those of a list, in ascending order; lanes beyond its end read what they like.
    #[inline(always)]
    pub fn listed(list: &[u32]) -> Self {
        let (first, last) = (list[0], list[list.len() - 1]);
        if (last - first) as usize == list.len() - 1 {
            return Self::From(first as usize);
        }
        Self::Each(R::B::from_fn(|lane| {
            list.get(lane).copied().unwrap_or(first)
        }))
    }
}

/// To which columns lanes write.
#[derive(Clone, Copy, Debug)]
pub struct Packed<R: Real> {
    first: usize,
    /// How lanes that are kept come first, unless all are.
    order: Option<R::B>,
}

impl<R: Real> Packed<R> {
    /// Lanes where the mask holds, from column `first` on; what follows them is overwritten.
    #[inline(always)]
    pub fn new(first: usize, lanes: R::M) -> Self {
        let all = lanes.bits() == R::everywhere().bits();
        Self {
            first,
            order: if all { None } else { Some(R::order(lanes)) },
        }
    }
}

impl<const N: usize> Default for Rows<N> {
    /// Zeros.
    fn default() -> Self {
        Self(Box::new([[0.0; LENGTH]; N]))
    }
}

impl<const N: usize> Rows<N> {
    /// The numbers of a row.
    #[inline(always)]
    pub fn get<R: Real>(&self, row: usize, columns: Columns<R>) -> R {
        match columns {
            Columns::From(first) => R::load(&self.0[row], first),
            Columns::Each(columns) => R::gather(&self.0[row], columns),
        }
    }

    /// The vectors of three rows.
    #[inline(always)]
    pub fn vector<R: Real>(&self, row: usize, columns: Columns<R>) -> V3<R> {
        V3::new(
            self.get(row, columns),
            self.get(row + 1, columns),
            self.get(row + 2, columns),
        )
    }

    /// Writes numbers into a row.
    #[inline(always)]
    pub fn put<R: Real>(&mut self, row: usize, columns: Packed<R>, value: R) {
        let value = match columns.order {
            None => value,
            Some(order) => value.ordered(order),
        };
        value.store(&mut self.0[row], columns.first);
    }

    /// Writes vectors into three rows.
    #[inline(always)]
    pub fn put_vector<R: Real>(&mut self, row: usize, columns: Packed<R>, v: V3<R>) {
        self.put(row, columns, v.x);
        self.put(row + 1, columns, v.y);
        self.put(row + 2, columns, v.z);
    }
}
