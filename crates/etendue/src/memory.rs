//! Memory: what a picture will take, what there is, what was taken.

/// The most memory that the process has held, bytes; zero where the system does not tell.
pub fn peak() -> u64 {
    proc_field("/proc/self/status", "VmHWM:").unwrap_or(0)
}

/// Memory that can still be had, bytes; `None` where the system does not tell.
pub fn available() -> Option<u64> {
    let free = proc_field("/proc/meminfo", "MemAvailable:")?;
    Some(cgroup_room().map_or(free, |room| room.min(free)))
}

/// What a container's limit leaves.
fn cgroup_room() -> Option<u64> {
    let read = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?.trim().parse::<u64>().ok();
    Some(read("memory.max")?.saturating_sub(read("memory.current")?))
}

/// A `Name:   123 kB` line.
fn proc_field(file: &str, field: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(field))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// A number of bytes for people.
pub fn human(bytes: u64) -> String {
    let b = bytes as f64;
    match bytes {
        0..=9_999 => format!("{bytes} B"),
        10_000..=9_999_999 => format!("{:.0} KiB", b / 1024.0),
        10_000_000..=9_999_999_999 => format!("{:.0} MiB", b / (1024.0 * 1024.0)),
        _ => format!("{:.1} GiB", b / (1024.0 * 1024.0 * 1024.0)),
    }
}
