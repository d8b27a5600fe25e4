// Runs in the page before viser does; UPRIGHT is where the camera stands in an upright window.
//
// viser logs each connection to the console and warns of a class of three.js that it uses itself.
// Neither is of use here; every other warning and every error stays.
(() => {
  const KNOWN = ['THREE.Clock: This module has been deprecated'];
  const silence = (scope, known) => {
    scope.console.log = scope.console.info = scope.console.debug = () => {};
    const warn = scope.console.warn.bind(scope.console);
    scope.console.warn = (...words) => {
      if (!known.some((each) => words.join(' ').includes(each))) warn(...words);
    };
  };
  silence(self, KNOWN);
  // a worker has a console of its own, and its source is a blob made by the page
  const head = `(${silence})(self, ${JSON.stringify(KNOWN)});\n`;
  const BrowserBlob = self.Blob;
  self.Blob = class extends BrowserBlob {
    constructor(parts = [], options = {}) {
      const script = (options.type || '').startsWith('text/javascript');
      super(script ? [head, ...parts] : parts, options);
    }
  };

  // the page is dark where the system is, and turns with it; in an upright window the panel lies
  // across the lower half, and the camera keeps the arm above it
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const address = new URL(location);
  const parameters = { darkMode: dark.matches && '' };
  const upright = innerWidth < 0.8 * innerHeight;
  for (const [name, value] of Object.entries(UPRIGHT)) parameters[name] = upright && value.join(',');
  for (const [name, value] of Object.entries(parameters)) {
    if (value === false) address.searchParams.delete(name);
    else address.searchParams.set(name, value);
  }
  history.replaceState(null, '', address);
  dark.addEventListener('change', () => location.reload());

  // an arrow that moves the timeline must not turn the camera as well
  for (const kind of ['keydown', 'keyup']) {
    document.documentElement.addEventListener(kind, (event) => {
      if (event.target.closest?.('[role=slider]')) event.stopPropagation();
    });
  }
})();
