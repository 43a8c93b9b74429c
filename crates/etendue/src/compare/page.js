"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const stage = $("stage"), a = $("a"), b = $("b"), flip = $("flip"), ev = $("ev");
  const images = [...stage.querySelectorAll("img")];
  const [tagLeft, tagRight] = stage.querySelectorAll(".tag");
  let at = 50, flipping = false, first = true;

  const name = (select) => select.options[select.selectedIndex].text;
  function show() {
    // In flip mode one picture fills the stage, and the next flip shows the other in its place.
    const border = flipping ? (first ? 100 : 0) : at;
    stage.style.setProperty("--at", border + "%");
    stage.classList.toggle("flipping", flipping);
    stage.setAttribute("aria-valuenow", Math.round(border));
    images.forEach((image, i) => {
      image.classList.toggle("right", i === +b.value);
      image.classList.remove("left");
    });
    stage.querySelector("img.copy")?.remove();
    if (images[+a.value]) {
      const left = images[+a.value].cloneNode();
      left.className = "left copy";
      stage.prepend(left);
    }
    tagLeft.textContent = border > 4 ? name(a) : "";
    tagRight.textContent = border < 96 ? name(b) : "";
    flip.setAttribute("aria-pressed", flipping);
  }
  function move(event) {
    const box = stage.getBoundingClientRect();
    at = Math.min(100, Math.max(0, (100 * (event.clientX - box.left)) / box.width));
    flipping = false;
    show();
  }
  function turn() {
    first = flipping ? !first : true;
    flipping = true;
    show();
  }
  function expose() {
    const slope = 2 ** ev.value;
    document.querySelectorAll("#exposure feComponentTransfer *").forEach((f) => f.setAttribute("slope", slope));
    $("ev-out").textContent = (ev.value > 0 ? "+" : "") + String(+ev.value).replace("-", "\u2212") + " EV";
  }
  stage.addEventListener("pointerdown", (e) => { stage.setPointerCapture(e.pointerId); move(e); });
  stage.addEventListener("pointermove", (e) => { if (e.buttons) move(e); });
  stage.addEventListener("dragstart", (e) => e.preventDefault());
  [a, b].forEach((s) => s.addEventListener("change", show));
  flip.addEventListener("click", turn);
  ev.addEventListener("input", expose);
  document.addEventListener("keydown", (e) => {
    const on = e.target === document.body || e.target === stage;
    if (!on) return;
    if (e.key === " ") { e.preventDefault(); turn(); }
    if (e.key === "ArrowLeft" || e.key === "ArrowRight") {
      at = Math.min(100, Math.max(0, at + (e.key === "ArrowLeft" ? -2 : 2)));
      flipping = false;
      show();
    }
  });
  show();
})();
