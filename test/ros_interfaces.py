"""
The types of control_msgs, simulation_interfaces and ur_msgs, where those are not installed.

``test/interfaces`` declares the same fields. The rosidl generators that come with rclpy write the
code, and the C++ compiler makes one library of each package, once for each interpreter.
"""

import ctypes
import fcntl
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCES = Path(__file__).resolve().parent / 'interfaces'
PACKAGES = ('control_msgs', 'simulation_interfaces', 'ur_msgs')
#: Kinds of type support that rmw_fastrtps_cpp asks for.
SUPPORTS = ('rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c')
PREFIX = Path(sys.prefix)


def provide_interfaces() -> dict[str, str]:
    """
    Make the packages importable here; return the variables that do the same for a child process.

    Returns
    -------
    dict
        Empty where a ROS installation has the packages.

    """
    if all(importlib.util.find_spec(package) for package in PACKAGES):
        return {}
    folder = _built()
    sys.path.insert(0, str(folder))
    for library in folder.glob('*.so'):  # found by name from now on
        ctypes.CDLL(str(library))
    return {name: ':'.join(filter(None, (str(folder), os.environ.get(name, ''))))
            for name in ('PYTHONPATH', 'LD_LIBRARY_PATH')}


def _built() -> Path:
    """Return the folder of the built packages, after building them if they are not there."""
    content = hashlib.sha256(sys.version.encode() + Path(__file__).read_bytes())
    for path in sorted(SOURCES.rglob('*.*')):
        content.update(path.name.encode() + path.read_bytes())
    folder = PREFIX / 'test_interfaces' / content.hexdigest()[:16]
    folder.parent.mkdir(exist_ok=True)
    with open(folder.parent / 'lock', 'w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # tests that run at the same time wait for the first
        if not folder.exists():
            _build_all(folder)
    return folder


def _build_all(folder: Path) -> None:
    """Build the packages beside a folder, and give them its name when they are whole."""
    with tempfile.TemporaryDirectory(dir=folder.parent) as name:
        work, ready = Path(name), Path(name) / 'ready'
        # a process of its own, as the generators print and change the working folder
        environment = os.environ | {'AMENT_PREFIX_PATH': str(PREFIX)}
        for package in PACKAGES:
            subprocess.run([sys.executable, __file__, package, str(work / package)], check=True,
                           capture_output=True, env=environment)
            shutil.copytree(work / package / 'python', ready, dirs_exist_ok=True,
                            ignore=shutil.ignore_patterns('*.c', '*.o'))
        ready.rename(folder)


def generate(package: str, out: Path) -> None:
    """Write the C, C++ and Python sources of a package below a folder."""
    from rosidl_cli.command.translate.api import translate
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_generator_type_description.cli import HashTypeDescription
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    os.chdir(SOURCES / package)
    files = [str(path) for kind in ('msg', 'srv', 'action') for path in Path(kind).glob('*')]
    share = [str(folder) for folder in (PREFIX / 'share').iterdir()
             if any(folder.glob('*/*.idl'))]
    idl = translate(package_name=package, interface_files=files, output_format='idl',
                    include_paths=[str(PREFIX / 'share')], output_path=out / 'share' / package)
    types = HashTypeDescription('').generate_type_hashes(
        package, idl, share, out / 'share' / package)
    GenerateC('').generate(package, idl, share, out / 'c' / package,
                           type_description_files=types)
    for kind in (GenerateFastRTPSCTypesupport, GenerateIntrospectionCTypesupport):
        kind('').generate(package, idl, share, out / kind.__name__ / package)
    GenerateCTypesupport('', typesupport_implementations=list(SUPPORTS)).generate(
        package, idl, share, out / 'dispatch' / package)
    GeneratePython('', typesupport_implementations=['rosidl_typesupport_c']).generate(
        package, idl, share, out / 'python' / package)
    (out / 'python' / package / '__init__.py').touch()


def build(package: str, out: Path) -> None:
    """Compile everything once; link it under the three names that rclpy and Fast DDS ask for."""
    import numpy
    folders = [path for path in out.iterdir() if path.name not in ('share', 'python')]
    headers = [*folders, PREFIX / 'include', *(PREFIX / 'include').iterdir(),
               sysconfig.get_path('include'), numpy.get_include()]
    include = [f'-I{folder}' for folder in headers]
    sources = [path for folder in (*folders, out / 'python') for path in folder.rglob('*.c*')]

    def compiled(source: Path) -> str:
        target = str(source) + '.o'
        standard = '-std=c++17' if source.suffix == '.cpp' else '-std=gnu11'
        subprocess.run(['g++' if source.suffix == '.cpp' else 'gcc', standard, '-O0', '-fPIC',
                        '-c', '-w', *include, str(source), '-o', target], check=True)
        return target

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compiled, sources))
    module = f'{package}_s__rosidl_typesupport_c{sysconfig.get_config_var("EXT_SUFFIX")}'
    libraries = [str(path) for path in (PREFIX / 'lib').glob('lib*.so*') if _is_needed(path.name)]
    for name in (f'{package}/{module}', *(f'lib{package}__{support}.so' for support in SUPPORTS)):
        subprocess.run(['g++', '-shared', f'-Wl,-soname,{Path(name).name}', '-o',
                        str(out / 'python' / name), *objects, *libraries], check=True)


def _is_needed(name: str) -> bool:
    """Return whether a library of the ROS packages is one that messages are linked with."""
    kinds = ('__rosidl_generator_c.', '__rosidl_generator_py.', '__rosidl_typesupport_c.',
             '__rosidl_typesupport_fastrtps_c.', '__rosidl_typesupport_introspection_c.')
    names = ('librosidl_runtime_c.', 'librosidl_typesupport_', 'librcutils.', 'librmw.',
             'libfastcdr.')
    return any(kind in name for kind in kinds) or name.startswith(names)


if __name__ == '__main__':
    generate(sys.argv[1], Path(sys.argv[2]))
    build(sys.argv[1], Path(sys.argv[2]))
