"use strict";
(() => {
  const data = JSON.parse(document.getElementById("moving-data").textContent);
  const at = (id) => document.getElementById(id);
  const SVG = "http:" + "//www.w3.org/2000/svg";
  const COLORS = ["var(--one)", "var(--two)", "var(--three)"];
  const NEAR = 24; // pixels from a streamline that still pick it
  const DEEP = 0.1; // MPa below the vapor pressure at which the red is full
  const VAPOR = data.vapor; // MPa above the atmosphere, or null
  // A whole number in mm, s, MPa, and the digits that tell one from the next.
  const STEP = { mm: 1e3 * data.steps.length, s: data.steps.time, MPa: 1e-6 * data.steps.pressure };
  const digits = (step) => Math.max(0, Math.round(-Math.log10(step)));
  const DIGITS = { mm: digits(STEP.mm), s: Math.max(0, digits(STEP.s) - 1), MPa: digits(STEP.MPa) };
  const WORD = document.querySelector("label[for=pick-line]").textContent.toLowerCase();
  const WAY = 7000; // milliseconds that a fiber takes when it is played

  // From whole numbers to mm, s, MPa, degrees.
  const lines = data.lines.map((line) => ({
    number: line.n,
    near: line.near,
    time: line.t.map((v) => v * STEP.s),
    x: line.x.map((v) => v * STEP.mm),
    y: line.y.map((v) => v * STEP.mm),
    z: (line.z ?? line.x.map(() => 0)).map((v) => v * STEP.mm),
    own: line.p.map((v) => v * STEP.MPa),
    flow: line.d.map((v) => v / 10),
    climb: (line.de ?? line.d.map(() => 0)).map((v) => v / 10),
    lowest: line.low.map((v, i) => (v + line.p[i]) * STEP.MPa),
    highest: line.high.map((v, i) => (v + line.p[i]) * STEP.MPa),
    zones: line.zones.map((v) => v * STEP.s),
    fibers: line.fibers.map((f) => ({
      angle: f.a.map((v) => v / 10),
      rise: (f.e ?? f.a.map(() => 0)).map((v) => v / 10),
      low: f.low.map((v, i) => (v + line.p[i]) * STEP.MPa),
      high: f.high.map((v, i) => (v + line.p[i]) * STEP.MPa),
    })),
  }));
  const SPACE = "z" in data.lines[0]; // paths in space: seen from a side that can be turned
  const OUT = SPACE || "e" in data.lines[0].fibers[0]; // fibers that leave the plane
  const VIEWS = { side: [0, 0], above: [0, 90], along: [90, 0] }; // degrees about y, then about the screen's x
  const state = { picked: data.picked, shown: data.picked, start: 0, time: 0, view: SPACE ? "side" : "whole", turn: [0, 0] };

  const words = (value, digits) => {
    const text = value.toFixed(digits);
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
  };
  const turned = (angle) => ((((angle + 90) % 180) + 180) % 180) - 90;
  const element = (name, attributes, parent) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (parent) parent.append(made);
    return made;
  };
  const text = (parent, x, y, content, attributes = {}) => {
    element("text", { x, y, ...attributes }, parent).textContent = content;
  };
  const path = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
  const radians = Math.PI / 180;
  // Along a direction: an angle in the plane and one out of it.
  const unit = (angle, rise) => [Math.cos(rise * radians) * Math.cos(angle * radians), Math.cos(rise * radians) * Math.sin(angle * radians), Math.sin(rise * radians)];
  // On the screen, to the right and up.
  const seen = ([x, y, z]) => {
    const [yaw, pitch] = state.turn.map((angle) => angle * radians);
    const near = Math.cos(yaw) * z - Math.sin(yaw) * x;
    return [Math.cos(yaw) * x + Math.sin(yaw) * z, Math.cos(pitch) * y - Math.sin(pitch) * near];
  };
  // Between a fiber and the flow, neither of which has a head.
  const apart = (one, other) => Math.acos(Math.min(1, Math.abs(one.reduce((sum, v, k) => sum + v * other[k], 0)))) / radians;
  for (const one of lines) for (const own of one.fibers) {
    own.toFlow = own.angle.map((angle, i) => OUT
      ? apart(unit(angle, own.rise[i]), unit(one.flow[i], one.climb[i]))
      : angle - one.flow[i]);
  }
  const spots = (one) => one.x.map((x, i) => [x, one.y[i], one.z[i]]);
  const line = () => lines[state.shown];
  const fiber = () => line().fibers[state.start];

  // Where a time lies between two points of a line: the first, and the share of the way.
  const between = (times, time) => {
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    const share = (time - times[low]) / (times[high] - times[low] || 1);
    return [low, Math.min(1, Math.max(0, share))];
  };
  const value = (values, [k, share]) => values[k] + share * (values[k + 1] - values[k]);
  const deepest = () => {
    const low = fiber().low;
    return low.reduce((best, v, k) => (v < low[best] ? k : best), 0);
  };

  const inView = () => {
    if (!data.scene.whole) return true;
    const [left, right, bottom, top] = data.scene[state.view];
    const where = between(line().time, state.time);
    const x = value(line().x, where), y = value(line().y, where);
    return x >= left && x <= right && y >= bottom && y <= top;
  };

  // What is around the paths, and they.
  const scene = at("scene");
  let place = null; // from mm to pixels
  let glyph = null;
  // The part of the screen's plane that is drawn [mm].
  const bounds = () => {
    if (data.scene.whole) return data.scene[state.view];
    const all = [...lines.flatMap(spots), ...data.scene.edges.flat().map(([x, y, z = 0]) => [x, y, z])].map(seen);
    const [left, bottom, right, top] = all.reduce(
      ([l, b, r, t], [x, y]) => [Math.min(l, x), Math.min(b, y), Math.max(r, x), Math.max(t, y)],
      [Infinity, Infinity, -Infinity, -Infinity]);
    const room = 0.04 * Math.max(right - left, top - bottom);
    return [left - room, right + room, bottom - room, top + room];
  };
  const drawScene = () => {
    const [left, right, bottom, top] = bounds();
    const width = Math.max(240, scene.clientWidth);
    const head = data.scene.whole ? 0 : 44; // for the bar and the name
    const free = SPACE ? 0.62 * width : 1.2 * width;
    const scale = data.scene.whole ? width / (right - left) : Math.min(width / (right - left), free / (top - bottom));
    const height = Math.round(head + (SPACE ? free : (top - bottom) * scale));
    const aside = 0.5 * (width - (right - left) * scale), above = head + 0.5 * (height - head - (top - bottom) * scale);
    place = (spot) => {
      const [x, y] = seen([spot[0], spot[1], spot[2] ?? 0]);
      return [aside + (x - left) * scale, above + (top - y) * scale];
    };
    const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, height, "aria-hidden": "true" });
    const sides = data.scene.sides;
    const draw = (points, attributes) => element("path", { d: path(points.map(place)), fill: "none", ...attributes }, svg);
    const drawPieces = (pieces, attributes) => element("path", { d: pieces.map((piece) => path(piece.map(place))).join(""), fill: "none", ...attributes }, svg);
    if (sides) {
      draw([[left, 0], [right, 0], [right, bottom], [left, bottom]], { fill: "var(--bed)" });
      for (const [name, sign] of [["left wall", -1], ["right wall", 1]]) {
        const wall = sides[name];
        const outside = [...wall].reverse().map(([x, y]) => [x + sign * data.scene.thick, y]);
        draw([...wall, ...outside], { fill: "var(--metal)", stroke: "var(--metal-edge)", "stroke-width": 0.7 });
      }
      draw(Object.values(sides).flat(), { fill: "var(--fill)" });
      for (const [name, side] of Object.entries(sides)) {
        const firm = name.endsWith("wall") || name.endsWith("surface");
        draw(side, { stroke: firm ? "var(--ink)" : "var(--line)", "stroke-width": firm ? 1.2 : 0.7 });
      }
    } else drawPieces(data.scene.edges, { stroke: "var(--metal-edge)", "stroke-width": 0.6 });
    lines.forEach((one, k) => {
      if (k === state.shown) return;
      const marked = one.number in data.marked;
      draw(spots(one), {
        stroke: marked ? COLORS[data.marked[one.number] % 3] : "var(--line)",
        "stroke-width": marked ? 1.1 : 0.7,
        "stroke-opacity": marked ? 1 : 0.7,
      });
    });
    const points = spots(line());
    // Near a sharp corner numbers depend on the mesh: neither red nor the full line of what is harmless.
    const judged = VAPOR !== null && !line().near;
    draw(points, { stroke: "var(--ink)", "stroke-width": 2.6, "data-line": line().number, ...(line().near ? { "stroke-dasharray": "2 4" } : {}) });
    for (let i = 1; judged && i < points.length; i += 1) {
      const depth = VAPOR - 0.5 * (fiber().low[i - 1] + fiber().low[i]);
      if (depth > 0) {
        const strength = Math.min(1, depth / DEEP);
        draw([points[i - 1], points[i]], { stroke: "var(--below)", "stroke-width": 4, "stroke-opacity": strength, "stroke-linecap": strength < 1 ? "butt" : "round" });
      }
    }
    const millimetres = [100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].find((bar) => bar <= (right - left) / 3) ?? 0.01;
    const corner = [width - 12 - millimetres * scale, 16];
    element("path", { d: `M${corner[0]} ${corner[1]}h${millimetres * scale}`, stroke: "var(--ink)", "stroke-width": 2 }, svg);
    text(svg, corner[0] + (millimetres * scale) / 2, corner[1] + 14, `${millimetres} mm`, { "text-anchor": "middle" });
    text(svg, width - 12, corner[1] + 34, `${WORD} ${line().number}`, { "text-anchor": "end", class: "name" });
    const half = Math.max(15, 0.04 * width);
    glyph = element("ellipse", { fill: "var(--glyph)", stroke: "var(--ink)", "stroke-width": 1.2 }, svg);
    // A spheroid seen from a side: an ellipse, as long as its axis lies across.
    glyph.point = (angle, rise, [x, y]) => {
      const [across, up] = seen(unit(angle, rise));
      const long = across ** 2 + up ** 2;
      glyph.setAttribute("rx", (half * Math.sqrt(long + (1 - long) / data.ratio ** 2)).toFixed(1));
      glyph.setAttribute("ry", Math.max(1, half / data.ratio).toFixed(1));
      const turn = Math.atan2(-up, across) / radians;
      glyph.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turn.toFixed(1)})`);
    };
    scene.replaceChildren(svg);
  };

  // The charts. Each returns what sets its cursor to a time.
  const ticks = (low, high, most) => {
    const rough = (high - low) / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((s) => s * power).find((s) => s >= rough);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) found.push(k * step);
    return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
  };
  const LEFT = 44, RIGHT = 8, TOP = 8, BOTTOM = 20;
  const chart = (box, height, low, high, label, fixed) => {
    const width = Math.max(240, box.clientWidth);
    const end = line().time.at(-1);
    const X = (t) => LEFT + (t / end) * (width - LEFT - RIGHT);
    const Y = (v) => TOP + ((high - v) / (high - low)) * (height - TOP - BOTTOM);
    const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, height });
    const level = fixed ? { found: fixed, digits: 0 } : ticks(low, high, 5);
    for (const tick of level.found) {
      element("path", { d: `M${LEFT} ${Y(tick)}H${width - RIGHT}`, stroke: "var(--rule)", "stroke-width": 1 }, svg);
      text(svg, LEFT - 5, Y(tick) + 4, words(tick, level.digits), { "text-anchor": "end" });
    }
    const times = ticks(0, end, width < 360 ? 4 : 7);
    for (const tick of times.found) text(svg, X(tick), height - 5, words(tick, times.digits), { "text-anchor": "middle" });
    text(svg, LEFT + 4, TOP + 10, label, { class: "name" });
    text(svg, width - RIGHT, height - BOTTOM - 4, "s", { "text-anchor": "end" });
    line().zones.forEach((zone, k) => {
      element("path", { d: `M${X(zone)} ${TOP}V${height - BOTTOM}`, stroke: "var(--line)", "stroke-width": 0.8, "stroke-dasharray": "2 3" }, svg);
      text(svg, X(zone) + 3, height - BOTTOM - 4, String(data.zones[k]), {});
    });
    const curve = (values, attributes) =>
      element("path", { d: path(values.map((v, i) => [X(line().time[i]), Y(v)])), fill: "none", "stroke-width": 1.6, ...attributes }, svg);
    return { svg, X, Y, curve, width, end };
  };
  const cursor = (made, height) =>
    element("path", { d: `M0 ${TOP}V${height - BOTTOM}`, stroke: "var(--ink)", "stroke-width": 1.2 }, made.svg);
  const dot = (made, color) => element("circle", { r: 3.6, fill: color, stroke: "var(--panel)", "stroke-width": 1 }, made.svg);

  const pressureBox = at("pressure-chart"), angleBox = at("angle-chart");
  let follow = () => {};
  const drawCharts = () => {
    const one = line(), own = fiber();
    const low = Math.min(0, ...one.lowest), high = Math.max(50 * STEP.MPa, ...one.highest);
    const room = 0.06 * (high - low);
    const first = chart(pressureBox, 230, low - room, high + room, "pressure [MPa]");
    const band = [...one.highest.map((v, i) => [first.X(one.time[i]), first.Y(v)]),
      ...one.lowest.map((v, i) => [first.X(one.time[i]), first.Y(v)]).reverse()];
    element("path", { d: path(band) + "Z", fill: "var(--band)", "fill-opacity": 0.25 }, first.svg);
    element("path", { d: `M${LEFT} ${first.Y(0)}H${first.width - RIGHT}`, stroke: "var(--ink)", "stroke-width": 1 }, first.svg);
    if (VAPOR !== null && VAPOR < high + room) {
      element("path", { d: `M${LEFT} ${first.Y(VAPOR)}H${first.width - RIGHT}`, stroke: "var(--below)", "stroke-width": 1, "stroke-dasharray": "6 3" }, first.svg);
      text(first.svg, first.width - RIGHT, first.Y(VAPOR) - 4, "vapor", { "text-anchor": "end" });
    }
    first.curve(own.high, { stroke: "var(--high)" });
    first.curve(own.low, { stroke: "var(--low)" });
    first.curve(one.own, { stroke: "var(--melt)" });
    const here = cursor(first, 230);
    const dots = [dot(first, "var(--high)"), dot(first, "var(--low)"), dot(first, "var(--melt)")];
    pressureBox.replaceChildren(first.svg);

    const second = OUT ? chart(angleBox, 130, 0, 90, "angle to the flow [°]", [0, 45, 90])
      : chart(angleBox, 130, -90, 90, "angle [°]", [-90, -45, 0, 45, 90]);
    const curves = OUT ? [[own.toFlow, { stroke: "var(--two)" }]]
      : [[one.flow, { stroke: "var(--line)", "stroke-dasharray": "5 3" }], [own.angle, { stroke: "var(--two)" }]];
    for (const [values, attributes] of curves) {
      let d = "", last = null;
      values.forEach((v, i) => {
        const y = OUT ? v : turned(v);
        d += `${last === null || Math.abs(y - last) > 90 ? "M" : "L"}${second.X(one.time[i]).toFixed(1)} ${second.Y(y).toFixed(1)}`;
        last = y;
      });
      element("path", { d, fill: "none", "stroke-width": 1.6, ...attributes }, second.svg);
    }
    const there = cursor(second, 130), turn = dot(second, "var(--two)");
    angleBox.replaceChildren(second.svg);
    follow = (where) => {
      const x = first.X(state.time);
      here.setAttribute("transform", `translate(${x} 0)`);
      there.setAttribute("transform", `translate(${x} 0)`);
      [own.high, own.low, one.own].forEach((values, k) => {
        dots[k].setAttribute("cx", x);
        dots[k].setAttribute("cy", first.Y(value(values, where)));
      });
      turn.setAttribute("cx", x);
      turn.setAttribute("cy", second.Y(OUT ? value(own.toFlow, where) : turned(value(own.angle, where))));
    };
    toTime = (event, box) => {
      const x = event.clientX - box.getBoundingClientRect().left;
      setTime(((x - LEFT) / (first.width - LEFT - RIGHT)) * first.end);
    };
  };
  let toTime = () => {};

  // What changes with time only.
  const slider = at("pick-time");
  const showTime = () => {
    const one = line(), own = fiber(), end = one.time.at(-1);
    state.time = Math.min(end, Math.max(0, state.time));
    const where = between(one.time, state.time);
    const spot = [value(one.x, where), value(one.y, where), value(one.z, where)];
    const angle = value(own.angle, where), low = value(own.low, where);
    glyph.point(angle, value(own.rise, where), place(spot));
    follow(where);
    slider.value = Math.round((1000 * state.time) / end);
    const told = {
      time: `${words(state.time, DIGITS.s)} s`,
      place: `${spot.slice(0, SPACE ? 3 : 2).map((v) => words(v, DIGITS.mm)).join(", ")} mm`,
      own: `${words(value(one.own, where), DIGITS.MPa)} MPa`,
      low: `${words(low, DIGITS.MPa)} MPa`,
      high: `${words(value(own.high, where), DIGITS.MPa)} MPa`,
      bounds: `${words(value(one.lowest, where), DIGITS.MPa)} to ${words(value(one.highest, where), DIGITS.MPa)} MPa`,
      angle: OUT ? `${words(value(own.toFlow, where), 1)}°` : `${words(turned(angle), 1)}°, ${words(turned(angle - value(one.flow, where)), 1)}°`,
    };
    for (const [name, content] of Object.entries(told)) at(`out-${name}`).textContent = content;
    at("out-low").classList.toggle("below", VAPOR !== null && !one.near && low < VAPOR);
    slider.setAttribute("aria-valuetext", `${told.time}: lowest on the fiber ${told.low}, fiber at ${words(OUT ? value(own.toFlow, where) : turned(angle), 0)} degrees${OUT ? " to the flow" : ""}`);
  };
  const setTime = (time) => { state.time = time; showTime(); };

  const show = () => {
    drawScene();
    drawCharts();
    const k = deepest();
    at("out-deepest").textContent = `${words(fiber().low[k], DIGITS.MPa)} MPa at ${words(line().time[k], DIGITS.s)} s`;
    at("near").hidden = !line().near;
    at("start-shown").textContent = data.starts[state.start];
    at("pick-start").setAttribute("aria-valuetext", data.starts[state.start]);
    scene.setAttribute("aria-valuenow", state.shown + 1);
    scene.setAttribute("aria-valuetext", `${WORD} ${line().number}, lowest on the fiber ${at("out-deepest").textContent}`);
    showTime();
  };
  // Another line is met at the same share of its way, so that the fiber does not jump about.
  const showLine = (k) => {
    if (k === state.shown) return;
    const share = state.time / line().time.at(-1);
    state.shown = k;
    state.time = share * line().time.at(-1);
    show();
  };
  const pick = (k) => {
    state.picked = Math.min(lines.length - 1, Math.max(0, k));
    at("pick-line").value = state.picked;
    showLine(state.picked);
  };

  const nearest = (event) => {
    const box = scene.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    let found = null, closest = NEAR ** 2;
    lines.forEach((one, k) => spots(one).forEach((spot) => {
      const [px, py] = place(spot);
      const away = (px - x) ** 2 + (py - y) ** 2;
      if (away < closest) { closest = away; found = k; }
    }));
    return found;
  };
  // Paths in space are turned by dragging; a finger that goes up or down still moves the page.
  let held = null;
  const turnBy = (yaw, pitch) => {
    state.turn = [state.turn[0] + yaw, Math.max(-90, Math.min(90, state.turn[1] + pitch))];
    press(null);
    drawScene();
    showTime();
  };
  scene.addEventListener("pointerdown", (event) => {
    held = SPACE ? { x: event.clientX, y: event.clientY, moved: 0 } : null;
    if (held) scene.setPointerCapture(event.pointerId);
  });
  for (const end of ["pointerup", "pointercancel"]) scene.addEventListener(end, () => { if (held?.moved < 4) held = null; });
  scene.addEventListener("pointermove", (event) => {
    if (held && event.buttons) {
      const [x, y] = [event.clientX - held.x, event.clientY - held.y];
      held = { x: event.clientX, y: event.clientY, moved: held.moved + Math.abs(x) + Math.abs(y) };
      if (held.moved >= 4) turnBy(0.5 * x, 0.5 * y);
      return;
    }
    if (event.pointerType !== "mouse") return;
    const found = nearest(event);
    showLine(found === null ? state.picked : found);
  });
  scene.addEventListener("pointerleave", () => showLine(state.picked));
  scene.addEventListener("click", (event) => {
    const dragged = held !== null;
    held = null;
    if (dragged) return;
    const found = nearest(event);
    if (found !== null) pick(found);
  });
  const STEPS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, Home: -Infinity, End: Infinity };
  scene.addEventListener("keydown", (event) => {
    if (!(event.key in STEPS)) return;
    event.preventDefault();
    if (SPACE && event.shiftKey) {
      turnBy(...({ ArrowRight: [10, 0], ArrowLeft: [-10, 0], ArrowUp: [0, -10], ArrowDown: [0, 10] }[event.key] ?? [0, 0]));
      return;
    }
    pick(state.picked + STEPS[event.key]);
  });
  for (const box of [pressureBox, angleBox]) {
    box.addEventListener("pointerdown", (event) => { stop(); toTime(event, box); box.setPointerCapture(event.pointerId); });
    box.addEventListener("pointermove", (event) => { if (event.buttons) toTime(event, box); });
  }

  const chooser = at("pick-line");
  lines.forEach((one, k) => {
    const option = document.createElement("option");
    option.value = k;
    option.textContent = String(one.number) + (one.near ? ", near a corner" : "");
    chooser.append(option);
  });
  chooser.addEventListener("change", () => pick(Number(chooser.value)));
  const starts = at("pick-start");
  starts.max = data.starts.length - 1;
  starts.addEventListener("input", () => { state.start = Number(starts.value); show(); });
  starts.closest("p").hidden = data.starts.length < 2;
  slider.addEventListener("input", () => { stop(); setTime((slider.value / 1000) * line().time.at(-1)); });
  const choices = [...document.querySelectorAll("#moving [data-view]")];
  function press(view) {
    for (const one of choices) one.setAttribute("aria-pressed", String(one.dataset.view === view));
  }
  for (const choice of choices) {
    choice.addEventListener("click", () => {
      state.view = choice.dataset.view;
      state.turn = VIEWS[state.view] ?? [0, 0];
      if (!inView()) state.time = line().time[deepest()];
      press(state.view);
      show();
    });
  }

  // Playing: only when asked, and it stops at the outlet.
  const button = at("play");
  let playing = 0;
  function stop() {
    cancelAnimationFrame(playing);
    playing = 0;
    button.textContent = "▶";
    button.setAttribute("aria-label", "Play");
  }
  button.addEventListener("click", () => {
    if (playing) { stop(); return; }
    button.textContent = "❚❚";
    button.setAttribute("aria-label", "Pause");
    if (state.time >= line().time.at(-1)) state.time = 0;
    let last = performance.now();
    const step = (now) => {
      const end = line().time.at(-1);
      setTime(state.time + ((now - last) / WAY) * end);
      last = now;
      if (state.time < end) playing = requestAnimationFrame(step); else stop();
    };
    playing = requestAnimationFrame(step);
  });

  scene.classList.toggle("turns", SPACE);
  scene.setAttribute("aria-valuemin", 1);
  scene.setAttribute("aria-valuemax", lines.length);
  state.start = Math.floor(data.starts.length / 2);
  starts.value = state.start;
  chooser.value = state.picked;
  at("moving").hidden = false;
  state.time = line().time[deepest()];
  show();
  let width = scene.clientWidth;
  new ResizeObserver(() => {
    if (scene.clientWidth !== width) { width = scene.clientWidth; show(); }
  }).observe(scene);
})();
