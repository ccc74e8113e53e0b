"use strict";
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const el = (name, attributes = {}, ...content) => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...content);
    return made;
  };
  const svgEl = (name, attributes) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  };
  const short = (v) => (v === 0 ? "0" : String(Number(v.toPrecision(4)))).replace("-", "\u2212");
  const charts = new Map();

  // one chart: values under the pointer or at the arrow keys' place, zoom in x
  const prepare = (figure) => {
    const svg = figure.querySelector(":scope > svg"), data = svg.dataset;
    const number = (name) => Number(data[name]);
    const chart = {
      figure, svg, left: number("left"), wide: number("wide"), top: number("top"), high: number("high"),
      x0: number("x0"), x1: number("x1"), y0: number("y0"), y1: number("y1"),
      xLog: "xLog" in data, yLog: "yLog" in data, share: 0.5, from: 0, to: 1, lines: null,
    };
    chart.readout = el("div", { class: "readout", "aria-live": "polite" });
    (figure.querySelector(":scope > .legend") || svg).after(chart.readout);
    const back = (share, low, high, log) => (log ? low * (high / low) ** share : low + share * (high - low));
    chart.xAt = (share) => back(share, chart.x0, chart.x1, chart.xLog);
    chart.yAt = (share) => back(share, chart.y0, chart.y1, chart.yLog);
    chart.shareOf = (x) =>
      chart.xLog ? Math.log(x / chart.x0) / Math.log(chart.x1 / chart.x0) : (x - chart.x0) / (chart.x1 - chart.x0);
    const lines = () => {
      if (!chart.lines)
        chart.lines = [...svg.querySelectorAll("path.line[data-label]")].map((path) => ({
          label: path.dataset.label,
          pieces: path.getAttribute("d").split("M").filter(Boolean).map((piece) => piece.split("L").map((p) => p.split(" ").map(Number))),
        }));
      return chart.lines;
    };
    const layer = svgEl("g", {});
    svg.append(layer);
    const px = (share) => chart.left + (chart.wide * (share - chart.from)) / (chart.to - chart.from);
    // the value of a line at a place: between the samples beside it; none of a curve that turns back
    const valueAt = (line, place) => {
      for (const piece of line.pieces) {
        for (let i = 1; i < piece.length; i++) if (piece[i][0] < piece[i - 1][0]) return null;
        if (place < piece[0][0] || place > piece[piece.length - 1][0]) continue;
        let low = 0, high = piece.length - 1;
        while (high - low > 1) { const mid = (low + high) >> 1; if (piece[mid][0] <= place) low = mid; else high = mid; }
        const [xa, ya] = piece[low], [xb, yb] = piece[high];
        return xb > xa ? ya + ((yb - ya) * (place - xa)) / (xb - xa) : ya;
      }
      return null;
    };
    chart.showAt = (share) => {
      chart.share = Math.min(1, Math.max(0, share));
      layer.replaceChildren();
      const at = px(chart.share);
      if (at < chart.left - 0.5 || at > chart.left + chart.wide + 0.5) return;
      layer.append(svgEl("line", { class: "cursor", x1: at, x2: at, y1: chart.top, y2: chart.top + chart.high }));
      const said = [];
      for (const line of lines()) {
        const y = valueAt(line, chart.left + chart.wide * chart.share);
        if (y === null) continue;
        said.push(`${line.label}: ${short(chart.yAt(1 - (y - chart.top) / chart.high))}`);
        if (y >= chart.top && y <= chart.top + chart.high) layer.append(svgEl("circle", { class: "cursor-dot", cx: at, cy: y, r: 2.5 }));
      }
      chart.readout.textContent = said.length ? `${data.xName.replace(/ \[\u2013\]/, "")} ${short(chart.xAt(chart.share))} \u2192 ${said.join("; ")}` : "";
    };
    const all = (share) => {
      const group = figure.closest(".linked");
      const x = chart.xAt(Math.min(1, Math.max(0, share)));
      if (!group) return chart.showAt(share);
      for (const other of group.querySelectorAll("figure.chart")) {
        const c = charts.get(other);
        if (c && c.svg.dataset.xName === data.xName) c.showAt(c.shareOf(x));
      }
    };
    const nearest = (event) => {
      const box = svg.getBoundingClientRect(), unit = box.width / svg.viewBox.baseVal.width;
      const x = (event.clientX - box.left) / unit, y = (event.clientY - box.top) / unit;
      let best = null, least = 14;
      for (const mark of svg.querySelectorAll("[data-text].mark")) {
        const place = mark.getBBox(), far = Math.hypot(place.x + place.width / 2 - x, place.y + place.height / 2 - y);
        if (far < least) [best, least] = [mark.dataset.text, far];
      }
      if (best === null && event.target.tagName === "rect" && event.target.querySelector("title")) best = event.target.textContent;
      return [chart.from + ((x - chart.left) / chart.wide) * (chart.to - chart.from), best];
    };
    svg.addEventListener("pointermove", (event) => {
      const [share, text] = nearest(event);
      if (share < -0.02 || share > 1.02) return;
      all(share);
      if (text !== null) chart.readout.textContent = text;
    });
    svg.addEventListener("keydown", (event) => {
      const step = (event.shiftKey ? 0.1 : 0.01) * (chart.to - chart.from);
      if (event.key === "ArrowRight" || event.key === "ArrowLeft") all(chart.share + (event.key === "ArrowRight" ? step : -step));
      else if (event.key === "+" && chart.zoom) chart.zoom(0.5);
      else if (event.key === "-" && chart.zoom) chart.zoom(2);
      else if (event.key === "0" && chart.zoom) chart.zoom(Infinity);
      else return;
      event.preventDefault();
    });
    if ("zoom" in data) addZoom(chart);
    charts.set(figure, chart);
  };

  const addZoom = (chart) => {
    const inner = chart.svg.querySelector("svg.data"), labels = chart.svg.querySelector(".ticks-x");
    chart.zoom = (factor) => {
      const width = Math.min(1, (chart.to - chart.from) * factor);
      if (width < 0.005) return;
      const middle = Math.min(1 - width / 2, Math.max(width / 2, chart.share));
      [chart.from, chart.to] = [middle - width / 2, middle + width / 2];
      inner.setAttribute("viewBox", `${chart.left + chart.wide * chart.from} ${chart.top} ${chart.wide * width} ${chart.high}`);
      const low = chart.xAt(chart.from), high = chart.xAt(chart.to);
      const rough = (high - low) / 5, size = 10 ** Math.floor(Math.log10(rough));
      const step = [1, 2, 5, 10].map((n) => n * size).find((s) => s >= rough * 0.999999);
      labels.replaceChildren();
      for (let n = Math.ceil(low / step - 1e-9); n * step <= high * (1 + 1e-9); n++) {
        const text = svgEl("text", { x: chart.left + (chart.wide * (n * step - low)) / (high - low), y: chart.top + chart.high + 14, "text-anchor": "middle" });
        text.textContent = short(n * step);
        labels.append(text);
      }
      chart.showAt(chart.share);
    };
    const button = (word, name, factor) => {
      const made = el("button", { type: "button", "aria-label": `${name}: ${chart.figure.querySelector("figcaption").textContent}` }, word);
      made.addEventListener("click", () => chart.zoom(factor));
      return made;
    };
    chart.readout.after(el("div", { class: "controls" }, button("+", "Zoom in", 0.5), button("\u2212", "Zoom out", 2), button("All", "Show all", Infinity)));
  };

  const slider = (name, count, start, changed) => {
    const input = el("input", { type: "range", min: 0, max: count - 1, step: 1, value: start, "aria-label": name });
    const said = el("output", {});
    const set = (value) => { input.value = value; said.textContent = changed(Number(input.value)); input.setAttribute("aria-valuetext", said.textContent); };
    input.addEventListener("input", () => set(Number(input.value)));
    return { node: el("label", { class: "controls" }, name, input, said), set, input };
  };

  // one of several things at a time: marches by V_f, points of a sweep, Mach numbers
  const pick = (box) => {
    const choices = [...box.querySelectorAll(":scope > .choice")];
    if (choices.length < 2) return;
    const made = slider(box.dataset.name, choices.length, 0, (n) => {
      choices.forEach((choice, i) => choice.classList.toggle("away", i !== n));
      return choices[n].dataset.value;
    });
    box.prepend(made.node);
    made.set(Math.min(choices.length - 1, Number(box.dataset.start || 0)));
    box.picked = made;
    box.values = choices.map((choice) => Number(choice.dataset.number));
  };

  // V_f along the curves of a Mach number: values in both charts, and the march nearest to it
  const along = (box) => {
    const mine = [...box.querySelectorAll("figure.chart")].map((f) => charts.get(f)).filter((c) => c && c.svg.dataset.xName === box.dataset.along);
    if (!mine.length) return;
    const low = Number(box.dataset.low), high = Number(box.dataset.high), count = 201;
    const place = (n) => low * (high / low) ** (n / (count - 1));
    const made = slider("V_f", count, 100, (n) => {
      const x = place(n);
      mine.forEach((c) => c.showAt(c.shareOf(x)));
      const marches = box.querySelector(".picker");
      if (marches && marches.picked) {
        const far = marches.values.map((v) => Math.abs(Math.log(v / x)));
        marches.picked.set(far.indexOf(Math.min(...far)));
      }
      return `V_f ${x.toFixed(3)}`;
    });
    box.querySelector(".along-here").append(made.node);
    made.set(Math.round(((count - 1) * Math.log(Number(box.dataset.start) / low)) / Math.log(high / low)));
  };

  const film = (figure) => {
    const frames = [...figure.querySelectorAll(".film-frame")];
    if (frames.length < 2) return;
    const chart = charts.get(figure);
    const made = slider("Instant", frames.length, 0, (n) => {
      frames.forEach((frame, i) => frame.classList.toggle("shown", i === n));
      return frames[n].dataset.text;
    });
    const play = el("button", { type: "button", "aria-pressed": "false" }, "Play");
    let timer = 0;
    play.addEventListener("click", () => {
      if (timer) { clearInterval(timer); timer = 0; }
      else timer = setInterval(() => made.set((Number(made.input.value) + 1) % frames.length), frames.length > 12 ? 90 : 450);
      play.textContent = timer ? "Stop" : "Play";
      play.setAttribute("aria-pressed", String(Boolean(timer)));
    });
    made.node.prepend(play);
    (chart ? chart.readout : figure.lastElementChild).after(made.node);
    made.set(0);
  };

  const theme = () => {
    const root = document.documentElement;
    const button = el("button", { type: "button", class: "theme" });
    const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
    const name = () => (button.textContent = dark() ? "Light" : "Dark");
    button.addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; name(); });
    name();
    document.querySelector(".top").append(button);
  };

  document.querySelectorAll("figure.chart").forEach(prepare);
  document.querySelectorAll("figure.chart").forEach(film);
  document.querySelectorAll(".picker").forEach(pick);
  document.querySelectorAll("[data-along]").forEach(along);
  theme();
  document.documentElement.dataset.ready = "yes";
})();
