// The interface of engine and page: the JSON of a rig, and the messages of the worker. Only types, no code.
//
// Variables are called `component.variable`, a shared signal by its name (`Omega`), as in scenarios. Values are numbers in
// the unit of the variable; a Boolean is 0 or 1, an Enumeration its number. Points are integers: communication point n is
// at the time n * stepSize, 0 is the beginning of cycle 0, and the rotor settles before it.

// The rig --------------------------------------------------------------------------------------------------------------

/**
 * A variable of an FMU.
 * @typedef {object} Variable
 * @property {string} name
 * @property {number} reference value reference in the FMU of the model
 * @property {"Real" | "Integer" | "Boolean"} type an Enumeration is an Integer with `items`
 * @property {"parameter" | "input" | "output"} causality
 * @property {"fixed" | "tunable" | "continuous" | "discrete"} variability tunable parameters may be set while it runs
 * @property {string} unit empty without
 * @property {number | null} min
 * @property {number | null} max
 * @property {number | null} start start value if nothing is set; null for outputs
 * @property {string} description
 * @property {Record<string, number>} [items] values of an Enumeration by name
 */

/**
 * A component of the FMU.
 * @typedef {object} Component
 * @property {string} name
 * @property {string} model
 * @property {string} guid of the FMU of the model; components with the same have the same variables
 * @property {Variable[]} variables
 * @property {Record<string, number>} parameters initial values that differ from the model's start values
 */

/**
 * A change of an input at a point, which the scenario makes.
 * @typedef {object} PlannedEvent
 * @property {number} point
 * @property {string} variable
 * @property {number} value
 * @property {string} label of the event, or empty
 * @property {string} role of the event, or empty
 */

/**
 * An input that is linear between points and constant outside.
 * @typedef {object} Ramp
 * @property {string} variable
 * @property {[point: number, value: number][]} points
 * @property {string | null} slope signal that receives the derivative over the coming step (1/s)
 */

/**
 * A condition that ends the run: a signal above (or below) a limit at all points from `first` on for `hold` steps.
 * @typedef {object} StopCondition
 * @property {string} signal
 * @property {boolean} above
 * @property {number} limit
 * @property {number} first
 * @property {number} hold
 * @property {string} text
 */

/**
 * Data of the drawings. Lengths in m; z along the shaft. `shape` gives the deflected shaft from displacements of sensors: the
 * displacement of node k is the sum over j of shape.rows[k][j] times the displacement at place j.
 * @typedef {object} Geometry
 * @property {{ z: number, radius: number }[]} nodes of the shaft, from its left end; `radius` of the element that begins at the node
 * @property {{ name: string, z: number, radius: number, width: number, unbalance: boolean }[]} discs
 * @property {{ name: string, z: number, x: string, y: string, retainer: string, magnetic: boolean }[]} bearings signals of
 * displacement; whether magnets pull the rotor at it
 * @property {Site[]} sites retainers and bushes
 * @property {string} thrust name of the axial bearing, with the signals `rotor_contact.<thrust>.z` and so on; empty without
 * @property {Face[]} faces that stop the rotor along its shaft
 * @property {{ name: string, z: number, x: string, y: string }[]} planes of sensors, with their signals
 * @property {{ places: { z: number, x: string, y: string }[], rows: number[][] }} shape
 * @property {number} gravityAngle direction of gravity, from x towards y (rad)
 */

/**
 * A place where the rotor can touch. `x` and `y` are signals of its displacement from the centre of the clearance.
 * @typedef {object} Site
 * @property {string} name its variables are `rotor_contact.<name>.f_n` and so on
 * @property {string} bearing that it protects; empty for a bush
 * @property {number} z
 * @property {number} radius of the journal
 * @property {number} clearance at the start; the parameter `rotor_contact.<name>.clearance` has the present one
 * @property {string} x
 * @property {string} y
 */

/**
 * A face that stops the rotor along its shaft, at a seat.
 * @typedef {object} Face
 * @property {string} name its variables are `rotor_contact.<name>.f_n` and so on
 * @property {number} z of the face, with the rotor in the middle
 * @property {number} radius mean radius of the ring on which it lands
 * @property {number} clearance at the start; the parameter `rotor_contact.<name>.clearance` has the present one
 * @property {-1 | 1} stops direction of the motion along z that it stops
 * @property {string} retainer site on whose retainer it lands, or empty
 */

/**
 * A scenario with everything that is required to run it, except `Parts`.
 * @typedef {object} Rig
 * @property {1} format
 * @property {string} version of amb-cosim
 * @property {string} scenario name
 * @property {string} description
 * @property {string} source
 * @property {string} system name of a system, or path
 * @property {string | null} rotor as the scenario names it; null for the default rotor
 * @property {string | null} receptances file of the controller's table, as the scenario names it; for a table made in Python, its rotor
 * @property {boolean} gradient
 * @property {number} stepSize communication step in s
 * @property {number} rate communication steps in a second, an integer
 * @property {number} first point
 * @property {number} last point at which the scenario ends
 * @property {number} period of the initial speed (s)
 * @property {string} module key in `Parts` of the FMU, which has all components
 * @property {string} guid of the FMU
 * @property {string} data key in `Parts` of its constants, the file `resources/model.bin`
 * @property {string[]} variables names of its variables in order of their value references
 * @property {Component[]} components in the order in which they step
 * @property {{ name: string, targets: string[] }[]} signals shared ones, each feeding several inputs
 * @property {Record<string, number>} inputs initial values of signals and inputs that differ from the FMU's start values
 * @property {PlannedEvent[]} events
 * @property {Ramp[]} ramps
 * @property {StopCondition[]} stops
 * @property {string[]} recorded signals that a run of the scenario records
 * @property {Geometry} geometry
 */

/** Bytes by key: the modules and the constants of the FMUs. Rigs of a system and rotor share them.
 * @typedef {Record<string, Uint8Array>} Parts */

// Changes by the user --------------------------------------------------------------------------------------------------

/**
 * Start values of the user in place of the scenario's.
 * @typedef {object} Settings
 * @property {Record<string, number>} [values] of parameters, inputs and signals (`Omega`)
 * @property {boolean} [events] whether the scenario's events, ramps and stops take place; default: yes
 */

/**
 * A change that the user made: from `point` on, the variables have these values; a speed is reached at `until`.
 * @typedef {object} Change
 * @property {number} point
 * @property {number} time s
 * @property {Record<string, number>} values
 * @property {number} [until] point at which a ramp ends
 */

/**
 * All differences of the run from the scenario; the content of links and saved scenarios.
 * @typedef {object} UserChanges
 * @property {Settings} settings
 * @property {Change[]} changes in order of time
 */

// Page to worker -------------------------------------------------------------------------------------------------------
//
// All but `load` are refused before `ready`. Changes take place at the next communication point, not before point 0.

/**
 * @typedef {{ type: "load", rig: Rig, parts: Parts, userChanges?: UserChanges, watched?: string[] }} Load
 * Compile the module, start, settle, and pause at point 0. `userChanges` are those of a link: the settings apply from the start,
 * the changes at their points. `watched` are the signals of frames; default: those that the scenario records.
 *
 * @typedef {{ type: "play", pace: number }} Play simulated seconds in a second; Infinity: as fast as possible
 * @typedef {{ type: "pause" }} Pause
 * @typedef {{ type: "step" }} Step advance by one communication step, then pause
 * @typedef {{ type: "run", to: number }} Run compute up to a time (s) as fast as possible, then pause
 * @typedef {{ type: "reset", settings?: Settings }} Reset restart; default: with the present settings
 * @typedef {{ type: "set", values: Record<string, number> }} Set inputs, signals and tunable parameters; if any is refused, none is
 * set
 * @typedef {{ type: "speed", speed: number, acceleration: number }} Speed go to a speed (rad/s) at a rate (rad/s2), in
 * linear pieces of 0.1 s: a later request takes effect at the end of the present piece
 * @typedef {{ type: "push", disc: string, force: [number, number] }} Push force (N) on a disc until the next push on it
 * @typedef {{ type: "rewind", time: number, keep?: boolean }} Rewind go back to a time (s), and pause; changes after it
 * are dropped unless `keep`, which repeats them
 * @typedef {{ type: "save", name: string, description?: string }} Save request `saved`: the run so far as a scenario
 *
 * @typedef {Load | Play | Pause | Step | Run | Reset | Set | Speed | Push | Rewind | Save} Request
 */

// Worker to page -------------------------------------------------------------------------------------------------------

/**
 * Contact began, or ended (`mode` 0), or changed between sliding (1) and rolling (2).
 * @typedef {object} ContactEvent
 * @property {number} point at the end of the step in which it did
 * @property {number} time s
 * @property {string} site
 * @property {number} mode
 */

/**
 * Sent about 60 times a second during a run, and once after each request that changes the picture.
 * @typedef {object} Frame
 * @property {"frame"} type
 * @property {number} point
 * @property {number} time s
 * @property {"settling" | "playing" | "paused" | "failed"} status
 * @property {boolean} anew whether the rows are those of a new run or of an earlier time: discard all earlier rows from `from` on
 * @property {number} from first point of the rows; without rows, the point
 * @property {Float64Array} rows since the last frame, row by row: time (s), then a column for each watched signal
 * @property {Float64Array} values newest values of all signals, in the order of `Ready.signals`
 * @property {ContactEvent[]} contacts since the last frame
 * @property {number} speed largest possible pace (simulated seconds in a second)
 */

/**
 * @typedef {object} Ready
 * @property {"ready"} type
 * @property {string[]} signals names of all signals: inputs that nothing is connected to, then outputs
 * @property {string[]} watched columns of rows after time
 * @property {UserChanges} userChanges
 */

/**
 * @typedef {{ type: "userChanges", userChanges: UserChanges }} UserChangesUpdated sent after every change by the user
 * @typedef {{ type: "warning", component: string, time: number, text: string }} Warning that an FMU logged
 * @typedef {{ type: "refused", request: string, text: string }} Refused a request that was refused and changed nothing, with
 * the reason: the FMU's message if the FMU rejected a value
 * @typedef {{ type: "failed", component: string, time: number, text: string }} Failed a step failed, with the FMU's message, or the
 * engine's if `component` is empty; only `rewind` and `reset` continue
 * @typedef {{ type: "ended", reason: "completed" | "stopped" | "reached", time: number, text: string }} Ended paused at the
 * scenario's end, by a stop condition, or at the time of a `run` request; `play` continues
 * @typedef {{ type: "saved", name: string, toml: string }} Saved
 *
 * @typedef {Ready | Frame | UserChangesUpdated | Warning | Refused | Failed | Ended | Saved} Answer
 */

export {};
