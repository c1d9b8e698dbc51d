"use strict";
// Plots are drawn when they come into view, and again where light turns dark, in the colours of the style.
(function () {
  const COLOURS = 10; // of curves, in the style of the page
  const DASHES = ["solid", "dot", "dashdot"]; // of curves beyond the number of colours
  const data = JSON.parse(document.getElementById("plots").textContent);

  const ofPage = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = (k) => ofPage(`--curve-${k % COLOURS}`);

  // A dashed curve is a reference and takes no colour of its own.
  function traces(panel) {
    let k = -1;
    return panel.curves.map((curve) => {
      const isReference = curve.style === "dashed";
      k += isReference ? 0 : 1;
      return {
        name: curve.name, x: curve.x, y: curve.y, type: "scatter", mode: curve.style === "dots" ? "markers" : "lines",
        line: { color: isReference ? ofPage("--soft") : colour(k), width: 1.3, dash: isReference ? "dash" : DASHES[Math.floor(k / COLOURS) % DASHES.length] },
        marker: { color: colour(Math.max(k, 0)), size: 7, symbol: Math.max(k, 0) % 8 },
      };
    });
  }

  // Ranges of y, from the lower end of the axis; the lowest is darkest.
  function zones(panel) {
    const at = (y) => panel.log.includes("y") ? Math.log10(y) : y;
    let below = Math.min(panel.least, ...panel.holds);
    const shapes = [], annotations = [];
    panel.zones.forEach(([limit, name], k) => {
      if (below >= limit) { return; }
      const fillcolor = `rgba(128, 128, 128, ${0.28 - 0.2 * k / Math.max(panel.zones.length - 1, 1)})`;
      shapes.push({ type: "rect", layer: "below", xref: "paper", x0: 0, x1: 1, y0: below, y1: limit, fillcolor, line: { width: 0 } });
      annotations.push({ text: name, xref: "paper", x: 0, xanchor: "left", y: at(limit), yanchor: "top", showarrow: false, font: { size: 10 } });
      below = limit;
    });
    return { shapes, annotations };
  }

  function layout(panel) {
    const axis = (title) => ({ title: { text: title, standoff: 6 }, gridcolor: ofPage("--grid"), zeroline: false,
                               linecolor: "#999999", ticks: "outside", ticklen: 3, automargin: true });
    const x = axis(panel.x), y = axis(panel.y);
    if (panel.log.includes("x")) { x.type = "log"; }
    if (panel.log.includes("y")) { y.type = "log"; }
    if (panel.holds.length) { y.autorangeoptions = { include: panel.holds }; } // its limits
    if (panel.round) { y.scaleanchor = "x"; y.scaleratio = 1; }
    return { ...zones(panel), autosize: true,
             title: { text: innerWidth < 704 ? panel.title.replace(", ", ",<br>") : panel.title, font: { size: 14 }, x: 0, xref: "container", xanchor: "left", pad: { l: 8, b: 6 },
                      yref: "paper", y: 1, yanchor: "bottom" },
             xaxis: x, yaxis: y,
             hoverlabel: { bgcolor: ofPage("--band"), bordercolor: ofPage("--line"), font: { color: ofPage("--ink") } },
             modebar: { bgcolor: ofPage("--ground"), color: ofPage("--soft"), activecolor: ofPage("--ink") },
             margin: { l: 10, r: 10, t: 60, b: 10 }, font: { size: 12, color: ofPage("--ink") }, showlegend: panel.curves.length > 1,
             legend: { orientation: "h", yref: "container", y: 0, yanchor: "bottom" }, paper_bgcolor: ofPage("--ground"), plot_bgcolor: ofPage("--ground"),
             hovermode: "closest" };
  }

  // Move a range by a share of its width, and scale it about its middle.
  function changed(range, by, scale) {
    const [a, b] = range.map(Number), middle = (a + b) / 2 + by * (b - a), half = scale * (b - a) / 2;
    return [middle - half, middle + half];
  }

  function onKey(event) {
    const plot = event.currentTarget, layout = plot._fullLayout, step = 0.15;
    if (event.target !== plot || event.ctrlKey || event.altKey || event.metaKey) { return; }
    const move = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowDown: [0, -step], ArrowUp: [0, step] }[event.key];
    const scale = { "+": 0.7, "=": 0.7, "-": 1 / 0.7 }[event.key];
    if (move || scale) {
      const [dx, dy] = move || [0, 0];
      Plotly.relayout(plot, { "xaxis.range": changed(layout.xaxis.range, dx, scale || 1),
                              "yaxis.range": changed(layout.yaxis.range, dy, 1) });
    } else if (event.key === "0") {
      Plotly.relayout(plot, { "xaxis.autorange": true, "yaxis.autorange": true });
    } else if (/^[1-9]$/.test(event.key) && plot.data.length >= Number(event.key)) {
      const k = Number(event.key) - 1;
      Plotly.restyle(plot, { visible: plot.data[k].visible === "legendonly" ? true : "legendonly" }, [k]);
    } else {
      return;
    }
    event.preventDefault();
  }

  const sizes = new ResizeObserver((entries) => entries.forEach((entry) => Plotly.Plots.resize(entry.target)));

  const drawn = new Map();
  matchMedia("screen and (prefers-color-scheme: dark)").addEventListener("change", () => {
    drawn.forEach((panel, plot) => Plotly.react(plot, traces(panel), layout(panel)));
  });

  function draw(place, panels) {
    const plots = panels.map(() => document.createElement("div"));
    place.append(...plots);
    plots.forEach((plot, k) => {
      plot.className = "plot";
      plot.style.setProperty("--curves", panels[k].curves.length);
      plot.tabIndex = 0;
      plot.setAttribute("role", "img");
      plot.setAttribute("aria-label", panels[k].title + ": " + panels[k].curves.map((curve) => curve.name).join(", "));
      plot.addEventListener("keydown", onKey);
    });
    plots.forEach((plot, k) => {
      Plotly.newPlot(plot, traces(panels[k]), layout(panels[k]),
                     { displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d"] })
        .then(() => sizes.observe(plot));
      drawn.set(plot, panels[k]);
    });
  }

  const observer = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((item) => item.isIntersecting)) {
      observer.unobserve(entry.target);
      draw(entry.target, data[entry.target.dataset.source] || []);
      entry.target.style.minHeight = "";
    }
  }, { rootMargin: "600px" });
  for (const place of document.querySelectorAll(".plots")) {
    place.style.minHeight = "20rem";
    observer.observe(place);
  }

  const boxes = [...document.querySelectorAll(".filter input")];
  function filter() {
    const states = new Set(boxes.filter((box) => box.checked).map((box) => box.value));
    for (const row of document.querySelectorAll(".statements tbody tr")) { row.hidden = !states.has(row.classList[0]); }
    for (const article of document.querySelectorAll("article")) {
      article.hidden = !article.querySelector(".statements tbody tr:not([hidden])");
    }
  }
  boxes.forEach((box) => box.addEventListener("change", filter));
})();
