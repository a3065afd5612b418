//! Timing on a machine that others use too: contestants take turns, and what counts are medians over the rounds.

use std::time::Instant;

/// One contestant: its name and a function that does its work once.
pub(crate) struct Contestant<'a> {
    pub(crate) name: &'static str,
    /// Units of work in one call, such as points.
    pub(crate) units: usize,
    pub(crate) work: Box<dyn FnMut() + 'a>,
}

impl<'a> Contestant<'a> {
    pub(crate) fn new(name: &'static str, units: usize, work: impl FnMut() + 'a) -> Self {
        Self {
            name,
            units,
            work: Box::new(work),
        }
    }
}

/// Nanoseconds a unit of every contestant in every round.
pub(crate) struct Rounds {
    names: Vec<&'static str>,
    ns: Vec<Vec<f64>>,
}

/// Lets the contestants take turns for `rounds` rounds, each for about `slice` seconds a round.
pub(crate) fn race(mut contestants: Vec<Contestant<'_>>, rounds: usize, slice: f64) -> Rounds {
    let calls: Vec<usize> = contestants
        .iter_mut()
        .map(|contestant| {
            (contestant.work)();
            let mut calls = 1;
            loop {
                let seconds = seconds_of(&mut contestant.work, calls);
                if seconds > 0.2 * slice {
                    return ((calls as f64 * slice / seconds) as usize).max(1);
                }
                calls *= 2;
            }
        })
        .collect();
    let mut ns = vec![Vec::with_capacity(rounds); contestants.len()];
    for _ in 0..rounds {
        for ((contestant, calls), ns) in contestants.iter_mut().zip(&calls).zip(&mut ns) {
            let seconds = seconds_of(&mut contestant.work, *calls);
            ns.push(seconds * 1e9 / (calls * contestant.units) as f64);
        }
    }
    let names = contestants
        .iter()
        .map(|contestant| contestant.name)
        .collect();
    Rounds { names, ns }
}

fn seconds_of(work: &mut dyn FnMut(), calls: usize) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        work();
    }
    start.elapsed().as_secs_f64()
}

impl Rounds {
    fn of(&self, name: &str) -> &[f64] {
        let place = self.names.iter().position(|known| *known == name);
        &self.ns[place.expect("the names are those of the contestants")]
    }

    /// Median and least time of a unit, in nanoseconds.
    pub(crate) fn ns(&self, name: &str) -> [f64; 2] {
        median_and_least(self.of(name).to_vec())
    }

    /// Median over the rounds of one contestant's time over another's, and the quotient of their least times.
    pub(crate) fn ratio(&self, name: &str, other: &str) -> [f64; 2] {
        let ratios = self.of(name).iter().zip(self.of(other)).map(|(x, y)| x / y);
        let [median, _] = median_and_least(ratios.collect());
        [median, self.ns(name)[1] / self.ns(other)[1]]
    }
}

fn median_and_least(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[0]]
}
