//! The table of `etendue verify --accept`.

use super::verify::percent;
use etendue::verify::{Acceptance, Accepted};
use etendue_solvers::agreement::Verdict;

pub fn report(a: &Accepted) -> String {
    let h = &a.header;
    let mut lines = vec![
        format!(
            "{} at {} x {} pixels in {} x {} blocks, seed {}, {} threads, {:.0} s; {} comparisons, false alarms {}",
            h.scene,
            h.size[0],
            h.size[1],
            h.blocks[0],
            h.blocks[1],
            h.seed,
            h.threads,
            a.seconds,
            a.tests,
            percent(h.standard.alpha)
        ),
        String::new(),
        format!(
            "{:<16}{:>8}{:>12}  {:<14}{:>22}{:>10}{:>7}  {:<22}{:>20}{:>10}  outcome",
            "solver", "target", "± block", "at", "spp seen + scattered", "time", "|t|", "largest at", "difference", "sees"
        ),
    ];
    lines.extend(a.solvers.iter().map(|s| row(s, a.tests > 0 && a.reference == s.solver)));
    lines.extend(a.left_out.iter().map(|(name, why)| format!("{name:<16}left out: {why}")));
    lines.push(String::new());
    lines.push(match a.verdict {
        Verdict::Pass => format!("PASS: each solver agrees with {} in every block", a.reference),
        Verdict::Fail => "FAIL: a difference that chance does not explain".to_owned(),
        Verdict::Inconclusive => format!("INCONCLUSIVE: {}", open(a)),
    });
    lines.join("\n")
}

/// What is open, and what was shown all the same.
fn open(a: &Accepted) -> String {
    if a.tests == 0 {
        return "nothing to compare with; what was rendered is kept".to_owned();
    }
    let names = |open: bool| {
        let of = a.solvers.iter().filter(|s| (s.verdict() == Verdict::Inconclusive) == open && s.solver != a.reference);
        of.map(|s| s.solver.as_str()).collect::<Vec<_>>().join(", ")
    };
    match a.solvers.iter().find(|s| s.solver == a.reference) {
        Some(Acceptance { needed: Some(_), .. }) => "nobody knows each block well enough".to_owned(),
        _ => match names(false) {
            none if none.is_empty() => format!("nobody but {} knows each block well enough", a.reference),
            some => format!("{some} agree with {} in every block; not known well enough: {}", a.reference, names(true)),
        },
    }
}

fn row(s: &Acceptance, is_reference: bool) -> String {
    let (t, place, difference) = s.worst.as_ref().map_or((String::new(), String::new(), String::new()), |w| {
        let place = format!("{} {}", w.area, ["red", "green", "blue"][w.channel.min(2)]);
        (format!("{:.2}", w.t.abs()), place, format!("{} ± {}", percent(w.difference), percent(w.standard_error)))
    });
    let wants = s.needed.map_or(String::new(), |needed| format!("; its target takes about {needed:.0} s"));
    let outcome = match s {
        _ if is_reference => format!("the reference{wants}"),
        Acceptance { differences: n @ 1.., .. } => format!("differs in {n} of them{wants}"),
        Acceptance { doubtful: n @ 1.., .. } => format!("doubtful in {n} of them: rare bright paths, or a fault{wants}"),
        Acceptance { worst: None, needed: Some(needed), .. } => format!("its target takes about {needed:.0} s"),
        Acceptance { worst: None, .. } => "its target is reached".to_owned(),
        Acceptance { needed: Some(_), .. } => format!("no difference at this error{wants}"),
        _ => "agrees".to_owned(),
    };
    let sees = s.visible.map_or(String::new(), percent);
    format!(
        "{:<16}{:>8}{:>12}  {:<14}{:>22}{:>10}{t:>7}  {place:<22}{difference:>20}{sees:>10}  {outcome}",
        s.solver,
        percent(s.target),
        percent(s.worst_error),
        s.worst_area.to_string(),
        format!("{} + {}", s.spp[0], s.spp[1]),
        format!("{:.1} s", s.seconds)
    )
}
