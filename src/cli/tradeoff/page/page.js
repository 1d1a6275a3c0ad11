"use strict";
// Draws the page from `report`: state, plot, panel, tables. Numbers, colours and scales are in page.html.
(() => {
  if (!report?.scenes?.length) return fail("it holds no scenes");

  // ---- state, and the address that keeps it ----
  const state = { scene: 0, point: null, error: null, cost: "time", knob: "", off: new Set(), sort: "time", down: false };
  const here = () => report.scenes[state.scene];
  const has = (key) => here().points.some((point) => ERRORS[key].of(point) > 0);
  const errorKey = () => state.error ?? (has(here().axis) ? here().axis : "all");
  const error = () => ERRORS[errorKey()];
  const cost = () => COSTS[state.cost];
  const picked = () => here().points.find((point) => point.id === state.point) ?? null;
  const knobOf = (point) => (point.knob ? `${point.technique}/${point.knob}` : "");

  function readAddress() {
    const given = new URLSearchParams(location.hash.slice(1));
    const scene = Number(given.get("scene") ?? 0);
    state.scene = report.scenes[scene] ? scene : 0;
    state.point = given.has("point") ? Number(given.get("point")) : null;
    state.error = given.get("error") in ERRORS ? given.get("error") : null;
    state.cost = given.get("cost") in COSTS ? given.get("cost") : "time";
    state.knob = here().points.some((point) => knobOf(point) === given.get("knob")) ? given.get("knob") : "";
  }
  function writeAddress() {
    const kept = new URLSearchParams({ scene: state.scene });
    if (picked()) kept.set("point", state.point);
    if (state.error) kept.set("error", state.error);
    if (state.cost !== "time") kept.set("cost", state.cost);
    if (state.knob) kept.set("knob", state.knob);
    try {
      history.replaceState(null, "", `#${kept}`);
    } catch { /* a sandboxed frame: the page works without an address */ }
  }

  // ---- what is on the plot ----
  const byNumber = (a, b) => {
    const [left, right] = [Number.parseFloat(a.value), Number.parseFloat(b.value)];
    return known(left) && known(right) ? left - right : 0;
  };
  function shown() {
    return here().points
      .filter((point) => !state.off.has(point.technique) && cost().of(point) > 0 && error().of(point) > 0)
      .map((point) => ({ point, cost: cost().of(point), error: error().of(point) }))
      .sort((a, b) => a.cost - b.cost || a.error - b.error);
  }
  // The report's own front where the plot shows what it was made for, and else the front of what the plot shows. Whether
  // the path tracer counts is the report's choice.
  function frontOf(spots) {
    const own = errorKey() === here().axis && state.cost === "time" && state.off.size === 0;
    if (own) return spots.filter(({ point }) => point.pareto);
    const counts = here().points.some((point) => point.technique === BASELINE && point.pareto);
    let least = Infinity;
    return spots.filter((spot) => {
      if ((!counts && spot.point.technique === BASELINE) || spot.error >= least) return false;
      least = spot.error;
      return true;
    });
  }
  // The time that the path tracer takes for the same error.
  function baselineTime(target) {
    const line = here().points.filter((point) => point.technique === BASELINE)
      .map((point) => ({ cost: COSTS.time.of(point), error: error().of(point) }))
      .filter((spot) => spot.cost > 0 && spot.error > 0);
    return crossing(line.sort((a, b) => a.cost - b.cost), target);
  }

  let spots = [];
  let front = [];
  let drawn = 0;
  const onFront = (point) => front.some((spot) => spot.point === point);
  function drawPlot() {
    drawn = $("frame").clientWidth;
    const width = Math.max(280, drawn);
    const height = Math.round(Math.max(330, Math.min(620, width * 0.74)));
    const [left, right, top, bottom] = [58, width - 12, 12, height - 46];
    const chart = $("chart");
    chart.setAttribute("viewBox", `0 0 ${width} ${height}`);
    chart.replaceChildren();
    $("tip").hidden = true;
    spots = shown();
    front = frontOf(spots);
    listFront();
    const missing = here().points.filter((p) => !state.off.has(p.technique)).length - spots.length;
    caption(missing);
    if (!spots.length) {
      chart.append(svg("text", { x: width / 2, y: height / 2, "text-anchor": "middle" }, "no points with these figures"));
      return;
    }
    const timed = state.cost === "time";
    const ends = timed ? spots.flatMap(({ point }) => [point.seconds.least, point.seconds.most]).filter((t) => t > 0) : [];
    const x = scale([...spots.map((spot) => spot.cost), ...ends], left, right, 52, cost().unit);
    const lowest = Math.min(...spots.map((spot) => spot.error));
    const noise = here().reference[`noise_${errorKey()}`];
    const heard = known(noise) && noise > lowest / 4;
    const y = scale([...spots.map((spot) => spot.error), ...(heard ? [noise] : [])], bottom, top, 24);
    for (const spot of spots) Object.assign(spot, { x: x.at(spot.cost), y: y.at(spot.error) });

    for (const { value, labelled, at } of x.lines) {
      chart.append(svg("line", { x1: at, x2: at, y1: top, y2: bottom, class: labelled ? "grid labelled" : "grid" }));
      if (labelled) chart.append(svg("text", { x: at, y: bottom + 16, "text-anchor": "middle" }, cost().tick(value)));
    }
    for (const { value, labelled, at } of y.lines) {
      chart.append(svg("line", { x1: left, x2: right, y1: at, y2: at, class: labelled ? "grid labelled" : "grid" }));
      if (labelled) chart.append(svg("text", { x: left - 6, y: at + 4, "text-anchor": "end" }, error().tick(value)));
    }
    chart.append(svg("rect", { x: left, y: top, width: right - left, height: bottom - top, class: "border" }));
    const middle = (top + bottom) / 2;
    chart.append(
      svg("text", { x: (left + right) / 2, y: height - 8, "text-anchor": "middle", class: "axis" }, `${cost().label} →`),
      svg("text", { x: 13, y: middle, transform: `rotate(-90 13 ${middle})`, "text-anchor": "middle", class: "axis" },
        `${error().label} →`),
      svg("text", { x: left + 8, y: bottom - 8, class: "better" }, "↙ better"));
    $("noise").hidden = !heard;
    if (heard) chart.append(svg("line", { x1: left, x2: right, y1: y.at(noise), y2: y.at(noise), class: "noise-line" }));

    const path = (list) => list.map((spot, i) => `${i ? "L" : "M"}${spot.x} ${spot.y}`).join("");
    const baseline = spots.filter(({ point }) => point.technique === BASELINE).sort((a, b) => byNumber(a.point, b.point));
    chart.append(svg("path", { d: path(baseline), class: "baseline-line" }));
    const stairs = front.map((spot, i) => (i ? `H${spot.x}V${spot.y}` : `M${spot.x} ${spot.y}`)).join("");
    chart.append(svg("path", { d: stairs, class: "front-line" }));
    const knob = spots.filter(({ point }) => knobOf(point) === state.knob && state.knob);
    knob.sort((a, b) => byNumber(a.point, b.point));
    if (knob.length) chart.append(svg("path", { d: path(knob), class: "knob-line", style: `stroke:${colour(knob[0].point.technique)}` }));

    for (const spot of spots) {
      const { point } = spot;
      const { least, most } = point.seconds ?? {};
      const owner = state.knob.split("/")[0];
      spot.dim = state.knob !== "" && knobOf(point) !== state.knob && !(point.technique === owner && !point.knob);
      const bar = timed && most > least && least > 0
        ? svg("path", { d: `M${x.at(least) - spot.x} 0H${x.at(most) - spot.x}`, class: "spread", style: `stroke:${colour(point.technique)}` })
        : null;
      spot.node = svg("g", {
        class: "point", transform: `translate(${spot.x} ${spot.y})`, tabindex: "-1", role: "button", "aria-label": spoken(point),
        focus: () => hover(spot), blur: () => hover(null),
      }, bar, svg("circle", { r: 11.5, class: "halo" }), onFront(point) ? svg("circle", { r: 8.2, class: "ring" }) : null, shape(point.technique));
      if (spot.dim) spot.node.classList.add("dim");
      chart.append(spot.node);
    }
    const values = beside(knob.map((spot) => ({ ...spot, text: String(spot.point.value) })), [left, right, top, bottom]);
    chart.append(...values.map(({ x: at, y: up, text }) => svg("text", { x: at, y: up, class: "value" }, text)));
    spots.find((spot) => !spot.dim)?.node.setAttribute("tabindex", "0");
    showPicked();
  }

  function caption(missing) {
    const left = missing > 0 ? ` Left out: ${missing} with no such figure or zero.` : "";
    const bars = state.cost === "time" ? " Bars: the least and the most time." : "";
    $("caption").textContent = `Up: ${error().label}; across: ${cost().label}; both logarithmic.${bars}${left} `
      + "Click a point to see its picture, or move with the arrow keys and press Enter.";
  }
  const spoken = (point) => `${named(point.technique)}, ${settingsOf(point)}: ${cost().text(cost().of(point))}, `
    + `${error().label} ${error().text(error().of(point))}${onFront(point) ? ", on the front" : ""}`;

  // ---- hovering, picking ----
  function hover(spot) {
    for (const other of spots) other.node?.classList.toggle("near", other === spot);
    const tip = $("tip");
    tip.hidden = !spot;
    if (!spot) return;
    const { point } = spot;
    const lines = [`${named(point.technique)}${onFront(point) ? " · on the front" : ""}`, settingsOf(point),
      `time ${seconds(point.seconds?.median)} (${spread(point.seconds)})`];
    if (point.indirect) lines.push(`indirect: RMSE ${rmse(point.indirect)}, mean ratio ${ratio(point.indirect.mean_ratio)}`);
    if (point.all) lines.push(`whole: RMSE ${rmse(point.all)}, mean ratio ${ratio(point.all.mean_ratio)}, FLIP ${ratio(point.all.flip)}`);
    tip.replaceChildren(...[...lines, mib(point.bytes)].map((line) => el("div", null, line)));
    const [width, high] = [$("frame").clientWidth, $("frame").clientHeight];
    const beside = spot.x + 16 + tip.offsetWidth <= width ? spot.x + 16 : spot.x - 16 - tip.offsetWidth;
    tip.style.left = `${Math.max(0, Math.min(beside, width - tip.offsetWidth))}px`;
    const below = spot.y + 16 + tip.offsetHeight <= high;
    tip.style.top = `${below ? spot.y + 16 : spot.y - 16 - tip.offsetHeight}px`;
  }
  function nearest(event) {
    const box = $("chart").getBoundingClientRect();
    const away = (spot) => (spot.dim ? Infinity : Math.hypot(spot.x - event.clientX + box.left, spot.y - event.clientY + box.top));
    const best = spots.reduce((a, b) => (a && away(a) <= away(b) ? a : b), null);
    return best && away(best) < (event.pointerType === "touch" ? 32 : 20) ? best : null;
  }
  function pick(id) {
    state.point = id;
    writeAddress();
    showPicked();
  }

  // ---- the panel: the front, or the point picked ----
  function listFront() {
    $("front").replaceChildren(...front.map(({ point, cost: paid, error: left }) =>
      el("li", null, el("button", { type: "button", click: () => pick(point.id) }, mark(point.technique),
        el("span", null, named(point.technique)), el("span", null, `${cost().text(paid)} · ${error().text(left)}`),
        el("code", null, settingsOf(point))))));
  }
  let view = null;
  function source(id, data) {
    $(id).hidden = !data;
    $(id).nextElementSibling.hidden = Boolean(data);
    if (data) $(id).src = data;
    else $(id).removeAttribute("src");
  }
  function flip(on) {
    const point = picked();
    const [mine, truth] = [point?.images?.[view], here().reference.images?.[view]];
    source("picture", on && truth ? truth : mine);
    $("picture-name").textContent = on && truth ? "the reference" : "this point";
  }
  function showPicked() {
    const point = picked();
    for (const { point: { id }, node } of spots) node.classList.toggle("picked", id === point?.id);
    for (const row of $("points").rows) row.classList.toggle("picked", row.dataset.id === String(point?.id));
    $("nothing").hidden = Boolean(point);
    $("picked").hidden = !point;
    if (!point) return;
    const paid = baselineTime(error().of(point));
    const more = known(paid) ? `${seconds(paid)} for this error: ${digits(paid / point.seconds?.median, 2)} times this time`
      : "this error is beyond its points";
    const fill = {
      name: `${named(point.technique)}${onFront(point) ? " · on the front" : ""}`, settings: settingsOf(point),
      knob: point.knob ? `(${point.knob} = ${point.value})` : "", time: seconds(point.seconds?.median),
      spread: spread(point.seconds), bytes: mib(point.bytes),
      baseline: point.technique === BASELINE ? "this is one of its points" : more,
    };
    for (const node of $("panel").querySelectorAll("[data-fill]")) {
      const [part, figure] = node.dataset.fill.split(" ");
      const format = { mean_ratio: ratio, flip: ratio }[figure] ?? percent;
      const value = () => (figure === "relative_rmse" ? rmse(point[part]) : format(point[part]?.[figure]));
      node.textContent = figure ? value() : fill[part];
    }
    $("picked-mark").replaceChildren(mark(point.technique));
    copyable($("picked-command"), point.command);
    const views = ["indirect", "all"].filter((key) => point.images?.[key] ?? here().reference.images?.[key]);
    if (!views.includes(view)) view = views.includes(here().axis) ? here().axis : views[0];
    for (const button of $("views").querySelectorAll("[data-view]")) {
      button.hidden = !views.includes(button.dataset.view);
      button.setAttribute("aria-pressed", button.dataset.view === view);
    }
    const truth = here().reference.images?.[view];
    $("flip").hidden = $("swipe").hidden = !(truth && point.images?.[view]);
    source("truth", truth);
    source("map", point.images?.error);
    $("pictures").classList.toggle("bare", !point.images);
    flip(false);
  }

  // ---- tables ----
  const COLUMNS = [
    ["front", "front", (p) => (p.pareto ? 1 : 0), (on) => (on ? "●" : "")],
    ["technique", "technique", (p) => named(p.technique)],
    ["settings", "settings", settingsOf],
    ["time", "time", (p) => p.seconds?.median, seconds],
    ["indirect", "indirect RMSE", ERRORS.indirect.of, percent],
    ["mean-indirect", "mean ratio", (p) => p.indirect?.mean_ratio, ratio],
    ["all", "whole RMSE", ERRORS.all.of, percent],
    ["mean-all", "mean ratio", (p) => p.all?.mean_ratio, ratio],
    ["flip", "FLIP", ERRORS.flip.of, ratio],
    ["bytes", "memory", (p) => p.bytes, mib],
  ];
  function drawTable() {
    const sortBy = (key) => {
      Object.assign(state, { down: key === state.sort ? !state.down : key === "front", sort: key });
      drawTable();
      $("points-head").querySelector("[aria-sort] button").focus();
    };
    $("points-head").replaceChildren(el("tr", null, COLUMNS.map(([key, label, , format]) => el("th", {
      scope: "col", class: format && key !== "front" ? "number" : null,
      "aria-sort": key === state.sort ? (state.down ? "descending" : "ascending") : null,
    }, el("button", { type: "button", click: () => sortBy(key) }, label)))));
    const of = COLUMNS.find(([key]) => key === state.sort)[2];
    const order = (a, b) => {
      const [left, right] = [of(a) ?? null, of(b) ?? null];
      if (left === null || right === null) return (left === null) - (right === null);
      const sign = typeof left === "string" ? left.localeCompare(right, "en", { numeric: true }) : left - right;
      return state.down ? -sign : sign;
    };
    const cell = (point) => ([key, label, value, format]) => {
      if (key === "technique") return el("td", null, el("button", { type: "button", class: "pick" }, mark(point.technique), ` ${value(point)}`));
      if (key === "settings") return el("td", { class: "text" }, el("code", null, value(point)));
      const text = key in point && label.endsWith("RMSE") ? rmse(point[key]) : format(value(point));
      return el("td", { class: key === "front" ? null : "number" }, text);
    };
    const rows = here().points.filter((point) => point.pareto || !$("only-front").checked).sort(order);
    $("points").replaceChildren(...rows.map((point) => el("tr", { "data-id": point.id, click: () => {
      pick(point.id);
      $("desk").scrollIntoView({ block: "start" });
    } }, COLUMNS.map(cell(point)))));
    showPicked();
  }
  function drawStages() {
    const { attribution = [], axis, points } = here();
    $("attribution").hidden = !attribution.length;
    $("attribution-error").textContent = ERRORS[axis].label;
    $("stages").replaceChildren(...attribution.map((stage) => {
      const base = points.find((point) => point.technique === stage.technique && !point.knob)?.[axis];
      const wide = `width:${Math.min(100, Math.abs(stage.share ?? 0) * 100)}%`;
      return el("tr", null, el("td", null, mark(stage.technique), ` ${named(stage.technique)}`), el("td", null, stage.stage),
        el("td", { class: "text" }, stage.exact, " ", el("code", { class: "side" }, stage.settings)),
        el("td", { class: "number" }, `${rmse(base)} → ${rmse(stage)}`),
        el("td", { class: "number" }, `${ratio(base?.mean_ratio)} → ${ratio(stage.mean_ratio)}`),
        el("td", null, el("div", { class: "share" }, el("span", { class: "number" }, share(stage.share)),
          el("i", null, el("b", { class: stage.share < 0 ? "worse" : null, style: wide })))));
    }));
  }

  // ---- everything of a scene ----
  function draw() {
    const scene = here();
    const { samples, bounces, seconds: took, noise_indirect: indirect, noise_all: all } = scene.reference;
    $("scenes").hidden = report.scenes.length < 2;
    $("scenes").replaceChildren(...report.scenes.map(({ name }, index) => el("button", {
      type: "button", "aria-current": index === state.scene ? "true" : null,
      click: () => { Object.assign(state, { scene: index, point: null, knob: "", error: null }); writeAddress(); draw(); },
    }, name)));
    $("scene-name").textContent = scene.name;
    const heard = [known(indirect) && `${percent(indirect)} of indirect light`, known(all) && `${percent(all)} of the whole`];
    const noise = heard.filter(Boolean).join(", ");
    $("scene-about").replaceChildren(
      `${scene.size.join(" × ")} pixels; errors of averages at ${scene.compared.join(" × ")}. Reference: ${samples} paths a `
        + `pixel, bounces: ${bounces}, ${seconds(took)}${noise ? `; its own noise ${noise}` : ""}. `,
      scene.view ? el("code", null, scene.view) : "", scene.credit ? ` ${scene.credit}` : "");
    $("front-of").textContent = ERRORS[scene.axis].label;
    for (const option of $("error").options) option.disabled = !has(option.value);
    if (state.error && !has(state.error)) state.error = null;
    $("error").value = errorKey();
    $("cost").value = state.cost;
    const techniques = [...new Set(scene.points.map((point) => point.technique))];
    $("legend").replaceChildren(...techniques.map((technique) => el("button", {
      type: "button", "aria-pressed": String(!state.off.has(technique)), click: ({ currentTarget }) => {
        if (!state.off.delete(technique)) state.off.add(technique);
        currentTarget.setAttribute("aria-pressed", String(!state.off.has(technique)));
        drawPlot();
      },
    }, mark(technique), named(technique))));
    const groups = techniques.map((technique) => {
      const knobs = [...new Set(scene.points.filter((p) => p.technique === technique && p.knob).map((p) => p.knob))];
      return knobs.length ? el("optgroup", { label: named(technique) }, knobs.map((knob) =>
        el("option", { value: `${technique}/${knob}` }, `${named(technique)}: ${knob}`))) : null;
    });
    $("knob").replaceChildren(el("option", { value: "" }, "all knobs"), ...groups.filter(Boolean));
    $("knob").value = state.knob;
    drawPlot();
    drawTable();
    drawStages();
  }
  for (const id of ["error", "cost", "knob"]) {
    $(id).addEventListener("change", () => {
      state[id] = $(id).value;
      writeAddress();
      drawPlot();
    });
  }
  $("only-front").addEventListener("change", drawTable);
  $("close").addEventListener("click", () => pick(null));
  $("chart").addEventListener("pointermove", (event) => hover(nearest(event)));
  $("chart").addEventListener("pointerleave", () => hover(null));
  $("chart").addEventListener("click", (event) => pick(nearest(event)?.point.id ?? state.point));
  $("chart").addEventListener("keydown", (event) => {
    const lit = spots.filter((spot) => !spot.dim);
    const spot = lit.find(({ node }) => node === document.activeElement);
    const steps = { ArrowRight: ["cost", 1], ArrowLeft: ["cost", -1], ArrowUp: ["error", 1], ArrowDown: ["error", -1] };
    if (event.key === "Escape") pick(null);
    else if (spot && (event.key === "Enter" || event.key === " ")) pick(spot.point.id);
    else if (spot && steps[event.key]) {
      const [by, step] = steps[event.key];
      lit.sort((a, b) => a[by] - b[by]);
      const next = lit[lit.indexOf(spot) + step] ?? spot;
      spot.node.setAttribute("tabindex", "-1");
      next.node.setAttribute("tabindex", "0");
      next.node.focus();
    } else return;
    event.preventDefault();
  });
  $("views").addEventListener("click", ({ target }) => {
    if (target.dataset.view) { view = target.dataset.view; showPicked(); }
  });
  $("flip").addEventListener("pointerdown", () => flip(true));
  for (const end of ["pointerup", "pointerleave", "pointercancel", "blur"]) $("flip").addEventListener(end, () => flip(false));
  const holds = ({ key, target, ctrlKey, metaKey }) => picked() && !ctrlKey && !metaKey
    && ((key.toLowerCase() === "r" && !/^(select|input)$/i.test(target.tagName)) || (target.id === "flip" && /^( |Enter)$/.test(key)));
  addEventListener("keydown", (event) => { if (holds(event) && !event.repeat) flip(true); });
  addEventListener("keyup", (event) => { if (holds(event)) flip(false); });
  $("swipe").addEventListener("click", () => {
    $("over").src = picked().images[view];
    $("under").src = here().reference.images[view];
    split(50);
    $("zoom").showModal();
  });
  addEventListener("hashchange", () => { readAddress(); draw(); });
  new ResizeObserver(() => {
    if (Math.abs($("frame").clientWidth - drawn) > 1) requestAnimationFrame(drawPlot);
  }).observe($("frame"));

  $("about").textContent = `twinlight ${report.version} on ${report.machine}${report.runs > 1 ? `, ${report.runs} runs` : ""}`;
  copyable($("command"), report.command);
  readAddress();
  draw();
  document.documentElement.dataset.state = "ready";
})();
