(function () {
  "use strict";
  // The player stands behind its figure; without a script the figure's own picture stays.
  var film = document.currentScript.previousElementSibling, data = film.dataset;
  var times = data.times.split(",").map(Number), wide = +data.width, high = +data.height;
  var button = film.querySelector("button"), slider = film.querySelector("input");
  var told = film.querySelector("output"), strip = film.querySelector("img");
  var figure = film.previousElementSibling, drawing = figure.querySelector("svg");
  var frame = document.createElement("div"), canvas = document.createElement("canvas");
  frame.style.cssText = "position:relative;min-width:680px";
  drawing.parentNode.insertBefore(frame, drawing);
  frame.appendChild(drawing);
  canvas.width = wide; canvas.height = high;
  canvas.style.cssText = "position:absolute;pointer-events:none;background:#fff;left:" + data.left + "%;top:" +
    data.top + "%;width:" + data.wide + "%;height:" + data.high + "%";
  frame.appendChild(canvas);
  var brush = canvas.getContext("2d"), now = +data.shown, playing = false, last = 0;
  function show(number) {
    now = number;
    brush.clearRect(0, 0, wide, high);
    brush.drawImage(strip, now % data.columns * wide, Math.floor(now / data.columns) * high, wide, high, 0, 0, wide, high);
    slider.value = now;
    told.textContent = "t = " + times[now].toFixed(3) + " s";
  }
  function step(instant) {
    if (!playing) { return; }
    if (instant - last >= +data.pause) {
      last = instant;
      show((now + 1) % times.length);
    }
    requestAnimationFrame(step);
  }
  function play(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (on) { requestAnimationFrame(step); }
  }
  button.addEventListener("click", function () { play(!playing); });
  slider.addEventListener("input", function () { play(false); show(+slider.value); });
  function ready() { film.hidden = false; show(now); }
  if (strip.complete) { ready(); } else { strip.addEventListener("load", ready); }
})();
