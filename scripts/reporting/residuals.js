// SPDX-License-Identifier: BSD-3-Clause
// Residuals of one try of a step over its iterations; a slider goes through the tries.
class Residuals {
  constructor(section, data) {
    this.data = data;
    this.at = Object.fromEntries(data.columns.map((name, k) => [name, k]));
    section.hidden = false;
    const controls = section.querySelector(".controls");
    this.slider = html("input", {type: "range", min: 0, max: data.tries.length - 1, value: 0}, controls);
    this.slider.setAttribute("aria-label", "step");
    html("button", {type: "button", onclick: () => this.show(this.longest())}, controls, "most iterations");
    html("button", {type: "button", onclick: () => this.show(this.next())}, controls, "next that failed");
    this.text = html("p", {className: "readout", id: "residuals-step"}, section);
    if (data.all > data.tries.length) {
      html("p", {className: "hint"}, section, `${data.tries.length} of ${data.all} are in this page: those that failed, the longest, and others evenly.`);
    }
    const label = "iteration of the step";
    this.charts = [["displacement", "m"], ["force", "N" + data.unit]]
      .filter(([quantity]) => quantity + "_residual" in this.at)
      .map(([quantity, unit]) => [quantity, new Chart(section, {
        name: "residual-" + quantity, title: `residual of the ${quantity} [${unit}]`, log: true, whole: true, label, curves: []})]);
    this.slider.addEventListener("input", () => this.show(Number(this.slider.value)));
    this.show(this.longest());
  }

  length(k) {
    return this.data.tries[k][this.at.displacement_residual].length;
  }

  longest() {
    let best = 0;
    for (let k = 1; k < this.data.tries.length; ++k) if (this.length(k) > this.length(best)) best = k;
    return best;
  }

  next() {
    const count = this.data.tries.length;
    for (let n = 1; n <= count; ++n) {
      const k = (Number(this.slider.value) + n) % count;
      if (!["converged", "explicit"].includes(this.data.tries[k][this.at.status])) return k;
    }
    return Number(this.slider.value);
  }

  show(k) {
    const row = this.data.tries[k];
    this.slider.value = k;
    const status = row[this.at.status] === "going_on" ? "given up by a solver, or still running" : row[this.at.status].replace("_", " ");
    this.text.textContent = `step ${row[this.at.step]} from t = ${digits(row[this.at.time])} s, dt = ${digits(row[this.at.dt])} s: ` +
      `${this.length(k)} iterations, ${status}`;
    for (const [quantity, chart] of this.charts) {
      const values = row[this.at[quantity + "_residual"]];
      const limits = row[this.at[quantity + "_limit"]] || [];
      const x = values.map((_, n) => n);
      chart.set([{name: "residual", x, y: values, dots: true}, {name: "limit", x, y: limits}]
        .filter((curve) => curve.y.some((y) => y !== null)));
    }
  }
}
