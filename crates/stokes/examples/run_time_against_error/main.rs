//! wip
mod clock;
mod plain;
mod yardsticks;

fn table<const SIZE: usize>() {
    let rounds = yardsticks::measure::<SIZE>(31, 2e-4);
    for [ours, plain] in yardsticks::PAIRS {
        let [ns, _] = rounds.ns(ours);
        let [yard, _] = rounds.ns(plain);
        let [ratio, least] = rounds.ratio(ours, plain);
        println!(
            "{:3} {ours:18} {ns:8.1} {yard:8.1} {ratio:6.2} {least:6.2}",
            SIZE - 1
        );
    }
}

fn main() {
    table::<1>();
    table::<3>();
    table::<5>();
    table::<9>();
    table::<17>();
    table::<33>();
    table::<65>();
}
