(function () {
  "use strict";
  var root = document.documentElement, readout = document.getElementById("readout");
  var tabs = Array.prototype.slice.call(document.querySelectorAll(".tabs button"));
  function show(chosen) {
    tabs.forEach(function (tab) {
      var on = tab === chosen;
      tab.setAttribute("aria-selected", on);
      document.getElementById(tab.getAttribute("aria-controls")).classList.toggle("shown", on);
    });
  }
  if (tabs.length) {
    root.classList.add("scripted");
    tabs.forEach(function (tab) { tab.addEventListener("click", function () { show(tab); }); });
    show(tabs[0]);
  }
  // Folded figures belong on paper too.
  window.addEventListener("beforeprint", function () {
    document.querySelectorAll("details").forEach(function (d) { d.open = true; });
  });
  function value(numbers, share) {
    var n = numbers.split(",").map(Number);
    return n[2] ? n[0] * Math.pow(n[1] / n[0], share) : n[0] + share * (n[1] - n[0]);
  }
  function digits(v) {
    var a = Math.abs(v);
    return a !== 0 && (a < 1e-3 || a >= 1e5) ? v.toExponential(2) : String(Number(v.toPrecision(4)));
  }
  document.addEventListener("pointermove", function (event) {
    var panel = event.target;
    if (!panel.classList || !panel.classList.contains("panel")) { readout.hidden = true; return; }
    var box = panel.getBoundingClientRect();
    var x = (event.clientX - box.left) / box.width, y = 1 - (event.clientY - box.top) / box.height;
    readout.textContent = panel.dataset.xl + ": " + digits(value(panel.dataset.x, x)) +
      "   ·   " + panel.dataset.yl + ": " + digits(value(panel.dataset.y, y));
    readout.hidden = false;
    readout.style.left = Math.min(event.clientX + 16, innerWidth - readout.offsetWidth - 8) + "px";
    readout.style.top = Math.max(8, event.clientY - 38) + "px";
  });
})();
