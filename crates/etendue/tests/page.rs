//! The page of `compare` in a browser without a head: it loads without a network and without an error, its pictures are there, and its controls do
//! what they say. Skipped, with a word, where there is no Chromium.

#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use std::path::{Path, PathBuf};
use std::process::Command;

/// A browser of the family, if there is one in the path.
fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name))).find(|file| file.is_file())
}

/// Notes errors before anything else runs.
const BEFORE: &str = "<script>window.faults = []; addEventListener('error', (e) => faults.push(String(e.message || e.target.tagName)), true);</script>";

/// Uses the controls, and writes what came of it where it can be read: `name=value` with `;` between.
const AFTER: &str = r##"<script>
addEventListener("load", () => {
  const $ = (s) => document.querySelector(s), all = (s) => [...document.querySelectorAll(s)], told = {};
  const key = (k) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: k, bubbles: true }));
  const at = () => $("#stage").style.getPropertyValue("--at"), tags = () => all(".tag").map((t) => t.textContent).join("|");
  told.pictures = all("img").every((i) => i.complete && i.naturalWidth > 0);
  told.begin = at() + " " + tags();
  key("ArrowRight"); told.right = at();
  key(" "); told.first = at() + " " + tags() + " " + $("#flip").getAttribute("aria-pressed");
  key(" "); told.second = at() + " " + tags();
  const box = $("#stage").getBoundingClientRect();
  $("#stage").setPointerCapture = () => {};
  $("#stage").dispatchEvent(new PointerEvent("pointerdown", { clientX: box.left + box.width / 4, clientY: box.top + 5, bubbles: true }));
  told.drag = at() + " " + $("#flip").getAttribute("aria-pressed");
  $("#ev").value = -2; $("#ev").dispatchEvent(new Event("input"));
  told.exposure = $("#ev-out").textContent + " " + $("#exposure feFuncG").getAttribute("slope");
  $("#b").value = 0; $("#b").dispatchEvent(new Event("change")); told.choice = tags();
  told.plot = all("#convergence circle").length > 6 && $("#convergence svg").getBoundingClientRect().width > 300;
  told.wide = document.documentElement.scrollWidth <= innerWidth;
  told.faults = faults.join(", ");
  const p = document.createElement("pre");
  p.textContent = "TOLD " + Object.entries(told).map(([k, v]) => k + "=" + v).join(";") + " END";
  document.body.append(p);
});
</script>"##;

fn dumped(browser: &Path, page: &Path, folder: &Path) -> String {
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=900,1200", "--host-resolver-rules=MAP * ~NOTFOUND"])
        .args(["--virtual-time-budget=3000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium in the path");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let run = Command::new(env!("CARGO_BIN_EXE_etendue"))
        .args(["compare", "cornell-box", "--solvers", "path-nee,path-mis", "--spp", "32", "--width", "16", "-o", "out", "-q"])
        .current_dir(folder.path())
        .output()
        .expect("the program starts");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));

    let page = std::fs::read_to_string(folder.path().join("out/index.html")).expect("the page");
    let page = page.replacen("<head>", &format!("<head>{BEFORE}"), 1).replacen("</body>", &format!("{AFTER}</body>"), 1);
    let file = folder.path().join("out/tested.html");
    std::fs::write(&file, page).expect("a file");
    let dom = dumped(&browser, &file, folder.path());
    let told = dom.split("<pre>TOLD ").nth(1).and_then(|t| t.split(" END").next());
    let told = told.unwrap_or_else(|| panic!("the page says nothing:\n{}", dom.chars().take(2000).collect::<String>()));
    let expected = "pictures=true;begin=50% path-nee|reference;right=52%;first=100% path-nee| true;second=0% |reference;drag=25% false;\
        exposure=\u{2212}2 EV 0.25;choice=path-nee|path-nee;plot=true;wide=true;faults=";
    assert_eq!(told, expected);
}
