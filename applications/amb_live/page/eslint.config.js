import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["vendor/", "node_modules/"] },
  js.configs.recommended,
  { languageOptions: { ecmaVersion: 2024, globals: { ...globals.browser, ...globals.worker, uPlot: "readonly" } } },
  { files: ["tests/**", "*.config.js"], languageOptions: { globals: globals.node } },
  {
    rules: {
      eqeqeq: "error", "no-var": "error", "prefer-const": "error", curly: "error", "max-len": ["off"],
    },
  },
];
