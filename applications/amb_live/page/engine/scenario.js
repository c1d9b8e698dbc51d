// A run as a scenario in TOML, which `amb-cosim run` repeats: it contains every value, of scenario and user.

/** @typedef {import("../protocol.js").Rig} Rig */
/** @typedef {import("../protocol.js").UserChanges} UserChanges */
/** @typedef {import("../protocol.js").Variable} Variable */
/** @typedef {Map<string, Record<string, number>>} ByComponent values of variables */

const SPEED = "Omega";

/**
 * Return a run as a scenario.
 * @param {Rig} rig
 * @param {UserChanges} userChanges
 * @param {readonly [point: number, value: number][]} speeds points of the speed, the first of which is at point 0
 * @param {number} end point
 * @param {string} [description]
 */
export function scenarioToml(rig, { settings, changes }, speeds, end, description = rig.description) {
  const variables = variablesOf(rig), values = { ...rig.inputs, ...settings.values }, planned = settings.events !== false;
  const speed = values[SPEED], period = 2 * Math.PI / speed, { stepSize, first } = rig;
  const top = {
    description,
    source: rig.source || undefined,
    system: rig.system,
    rotor: rig.rotor ?? undefined,
    receptances: rig.receptances ?? undefined,
    gradient: rig.gradient ? undefined : false,
    communication_step: stepSize,
    Omega: `${floatText(speed)} rad/s`,
    settle_cycles: (0 - first) * stepSize / period,
    end_time: Math.max(end, 1) * stepSize,
  };
  const events = [
    ...(planned ? rig.events : []).map(({ point, variable, value, label, role }) => ({ point, label, role, values: { [variable]: value } })),
    ...changes.filter(({ until }) => until === undefined).map(({ point, values }) => ({ point, label: "", role: "", values })),
  ].filter(({ point }) => point <= end).sort((a, b) => a.point - b.point);
  const { parameters, inputs } = startValues(rig, values, variables);
  const lines = [
    `# The run of the live rig up to t = ${end * stepSize} s, by amb-cosim ${rig.version}; it began as scenario ${rig.scenario}.`,
    ...Object.entries(top).filter(([, value]) => value !== undefined).map(([key, value]) => `${key} = ${tomlValue(value)}`),
    ...tables("parameters", parameters, variables),
    ...tables("inputs", inputs, variables),
    ...merged(events).flatMap(({ point, label, role, values }) => [
      "",
      "[[event]]",
      ...(label && label !== role ? [`label = ${JSON.stringify(label)}`] : []),
      ...(role ? [`role = ${JSON.stringify(role)}`] : []),
      `time = ${floatText(point * stepSize)}`,
      ...Object.entries(values).map(([name, value]) => {
        const input = firstInput(rig, name), [component, variable] = split(input);
        return `set.${component}.${JSON.stringify(variable)} = ${typedText(value, variables.get(input))}`;
      }),
    ]),
    ...speeds.filter(([point]) => point > 0).flatMap(([point, value]) =>
      ["", "[[speed]]", `time = ${floatText(point * stepSize)}`, `Omega = "${floatText(value)} rad/s"`]),
    ...(planned ? rig.stops : []).flatMap(({ signal, above, limit, first: from, hold }) => [
      "", "[[stop]]", `variable = ${JSON.stringify(signal)}`, `${above ? "above" : "below"} = ${floatText(limit)}`,
      `hold_time = ${floatText(hold * stepSize)}`, `from_time = ${floatText(from * stepSize)}`,
    ]),
  ];
  return `${lines.join("\n")}\n`;
}

/**
 * @param {Rig} rig
 * @returns {Map<string, Variable>} by `component.variable`
 */
function variablesOf({ components }) {
  return new Map(components.flatMap(({ name, variables }) =>
    variables.map((variable) => /** @type {[string, Variable]} */ ([`${name}.${variable.name}`, variable]))));
}

/** @param {Rig} rig @param {Record<string, number>} values @param {Map<string, Variable>} variables */
function startValues(rig, values, variables) {
  /** @type {ByComponent} */
  const parameters = new Map(rig.components.map(({ name, parameters: values }) => [name, { ...values }]));
  /** @type {ByComponent} */
  const inputs = new Map();
  for (const [name, value] of Object.entries(values)) {
    const input = firstInput(rig, name), [component, variable] = split(input), found = variables.get(input);
    if (name === SPEED || (input !== name && value === found?.start)) { continue; }
    const target = found?.causality === "parameter" ? parameters : inputs;
    target.set(component, { ...target.get(component), [variable]: value });
  }
  return { parameters, inputs };
}

/**
 * Merge consecutive events at a point with the same label.
 * @param {{ point: number, label: string, role: string, values: Record<string, number> }[]} events
 */
function merged(events) {
  /** @type {typeof events} */
  const result = [];
  for (const { point, label, role, values } of events) {
    const latest = result.at(-1);
    if (latest?.point === point && (latest.label === label || !label)) {
      latest.values = { ...latest.values, ...values };
    } else {
      result.push({ point, label, role, values });
    }
  }
  return result;
}

/**
 * Return the first input that a shared signal feeds; any other name unchanged.
 * @param {Rig} rig
 * @param {string} name
 */
function firstInput({ signals }, name) {
  return signals.find((signal) => signal.name === name)?.targets[0] ?? name;
}

/** Return component and variable of a full name. @param {string} name */
function split(name) {
  const dot = name.indexOf(".");
  return [name.slice(0, dot), name.slice(dot + 1)];
}

/** @param {string} kind @param {ByComponent} values @param {Map<string, Variable>} variables */
function tables(kind, values, variables) {
  return [...values].filter(([, item]) => Object.keys(item).length > 0).flatMap(([component, item]) => [
    "",
    `[${kind}.${component}]`,
    ...Object.entries(item).map(([name, value]) => `${JSON.stringify(name)} = ${typedText(value, variables.get(`${component}.${name}`))}`),
  ]);
}

/**
 * Return a value as TOML text of the variable's type.
 * @param {number} value
 * @param {Variable | undefined} variable
 */
function typedText(value, variable) {
  if (variable?.type === "Boolean") { return value === 0 ? "false" : "true"; }
  return variable?.type === "Integer" ? String(value) : floatText(value);
}

/**
 * Return a number as TOML text of a float with the same value.
 * @param {number} value
 */
function floatText(value) {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}

/** @param {string | number | boolean | undefined} value */
function tomlValue(value) {
  return typeof value === "number" ? floatText(value) : JSON.stringify(value);
}
