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
            "{:<16}{:>8}{:>12}  {:<14}{:>22}{:>9}{:>7}  {:<22}{:>20}  outcome",
            "solver", "target", "± block", "at", "spp seen + scattered", "time", "|t|", "largest at", "difference"
        ),
    ];
    lines.extend(a.solvers.iter().map(|s| row(s, a.reference.as_ref() == Some(&s.solver))));
    lines.extend(a.left_out.iter().map(|(name, why)| format!("{name:<16}left out: {why}")));
    lines.push(String::new());
    lines.push(match a.verdict {
        Verdict::Pass => format!("PASS: each solver agrees with {} in every block", a.reference.as_deref().unwrap_or("itself")),
        Verdict::Fail => "FAIL: a difference that chance does not explain".to_owned(),
        Verdict::Inconclusive => match &a.reference {
            Some(name) => format!("INCONCLUSIVE: who knows each block well enough agrees with {name}, but not all do"),
            None => "INCONCLUSIVE: nobody knows each block well enough".to_owned(),
        },
    });
    lines.join("\n")
}

fn row(s: &Acceptance, is_reference: bool) -> String {
    let (t, place, difference) = s.worst.as_ref().map_or((String::new(), String::new(), String::new()), |w| {
        let place = format!("{} {}", w.area, ["red", "green", "blue"][w.channel.min(2)]);
        (format!("{:.2}", w.t.abs()), place, format!("{} ± {}", percent(w.difference), percent(w.standard_error)))
    });
    let outcome = match (s.differences, s.needed) {
        _ if is_reference => "the reference".to_owned(),
        (1.., _) => format!("differs in {} of them", s.differences),
        (_, Some(needed)) => format!("not reached, would take about {needed:.0} s"),
        _ => "agrees".to_owned(),
    };
    format!(
        "{:<16}{:>8}{:>12}  {:<14}{:>22}{:>9}{t:>7}  {place:<22}{difference:>20}  {outcome}",
        s.solver,
        percent(s.target),
        percent(s.worst_error),
        s.worst_area.to_string(),
        format!("{} + {}", s.spp[0], s.spp[1]),
        format!("{:.1} s", s.seconds)
    )
}
