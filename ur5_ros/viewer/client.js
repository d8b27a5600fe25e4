// Runs in the page before viser does; UPRIGHT is where the camera stands in an upright window.
//
// The library notes each connection on the console and warns of a class of three.js that it uses
// itself. Nothing there is of use to whoever looks at an arm; whatever else is said stays.
(() => {
  const KNOWN = ['THREE.Clock: This module has been deprecated'];
  const hush = (scope, known) => {
    scope.console.log = scope.console.info = scope.console.debug = () => {};
    const warn = scope.console.warn.bind(scope.console);
    scope.console.warn = (...said) => {
      if (!known.some((each) => said.join(' ').includes(each))) warn(...said);
    };
  };
  hush(self, KNOWN);
  // a worker has a console of its own, and its source is a blob made by the page
  const head = `(${hush})(self, ${JSON.stringify(KNOWN)});\n`;
  const Plain = self.Blob;
  self.Blob = class extends Plain {
    constructor(parts = [], options = {}) {
      const script = (options.type || '').startsWith('text/javascript');
      super(script ? [head, ...parts] : parts, options);
    }
  };

  // the page is dark where the system is, and turns with it; in an upright window the panel lies
  // across the lower half, and the camera keeps the arm above it
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const address = new URL(location);
  const wanted = { darkMode: dark.matches && '' };
  const upright = innerWidth < 0.8 * innerHeight;
  for (const [name, value] of Object.entries(UPRIGHT)) wanted[name] = upright && value.join(',');
  for (const [name, value] of Object.entries(wanted)) {
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
