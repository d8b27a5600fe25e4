"""World files: ``config/worlds/<name>.yaml``, what stands around the arm and what it touches."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from ur5_ros.config.arms import arm_tool
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.records import Meta, Record, validate
from ur5_ros.config.solids import Size, Solid, base_pose, check_shape
from ur5_ros.config.strict_yaml import file_names, named_file, parse_yaml, read_text, read_yaml
from ur5_ros.errors import InputError

__all__ = ['EMPTY', 'EMPTY_WORLD', 'Body', 'Solid', 'World', 'base_pose', 'list_worlds',
           'load_world', 'parse_world', 'with_contact', 'with_tool', 'world_from', 'world_text']

#: The world without anything in it.
EMPTY = 'empty'

Name = Annotated[str, Meta(pattern=r'^[A-Za-z0-9_]{1,60}$')]
NotNegative = Annotated[float, Meta(ge=0.0)]

#: What parameters may replace in every body.
_REPLACED = ('friction', 'restitution', 'stiffness', 'damping')


class Body(Solid, frozen=True, kw_only=True):
    """Something that the arm can touch."""

    name: Name
    mass: NotNegative = 0.0
    """[kg]; 0 = fixed."""
    inertia: Annotated[list[Size], Meta(min_length=3, max_length=3)] | None = None
    """Moments about the axes of the shape [kg m^2]; those of a homogeneous body by default."""
    friction: NotNegative = 0.5
    """Coefficient of the pair with the arm, whose own is 1; of two bodies it is the product."""
    restitution: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    """Speed after an impact by the speed before."""
    stiffness: NotNegative = 0.0
    """Of the contact [N/m]; 0 = rigid."""
    damping: NotNegative = 0.0
    """Of a contact with stiffness [N s/m]."""
    colour: Annotated[list[Annotated[float, Meta(ge=0.0, le=1.0)]],
                      Meta(min_length=3, max_length=3)] = msgspec.field(
                          default_factory=lambda: [0.76, 0.64, 0.48])
    """Red, green, blue."""

    @property
    def free(self) -> bool:
        """Whether it moves."""
        return self.mass > 0.0

    @property
    def moments(self) -> list[float]:
        """Moments of inertia about the axes of the shape [kg m^2]; see :attr:`inertia`."""
        if self.inertia is not None:
            return list(self.inertia)
        m, r = self.mass, self.radius
        if self.shape == 'box':
            x, y, z = (edge**2 for edge in self.size)
            return [m * (y + z) / 12, m * (x + z) / 12, m * (x + y) / 12]
        if self.shape == 'sphere':
            return [0.4 * m * r**2] * 3
        across = m * (3 * r**2 + self.length**2) / 12
        return [across, across, 0.5 * m * r**2]


class World(Record, frozen=True, kw_only=True):
    """Everything around the arm."""

    name: str
    description: str
    source: str
    frame: Literal['base', 'base_link'] = 'base'
    """In which the poses of the bodies are given."""
    tool: list[Solid] = []
    """
    Shapes fixed to the flange, in ``tool0``, without mass (``payload.mass`` gives it one).

    Those of the arm's file if there are none.

    """
    self_contact: bool = False
    """Whether links of the arm that are three or more joints apart touch each other."""
    bodies: Annotated[list[Body], Meta(max_length=64)] = []

    @property
    def empty(self) -> bool:
        """Whether there is nothing to touch."""
        return not self.bodies and not self.self_contact

    def body(self, name: str) -> Body | None:
        """Return a body by name; None if there is none."""
        return next((body for body in self.bodies if body.name == name), None)


EMPTY_WORLD = World(name=EMPTY, description='Nothing to touch.', source='')


def list_worlds() -> list[str]:
    """Return the names of the worlds that come with the package."""
    return [EMPTY, *file_names('world')]


def world_text(name: str) -> str:
    """Return the YAML text of a world, to be stored beside what was done in it; empty for none."""
    return '' if name == EMPTY else read_text(named_file('world', name))


def load_world(name: str) -> World:
    """
    Return a world from its file.

    Returned: the record; paths of meshes are absolute.
    """
    if name == EMPTY:
        return EMPTY_WORLD
    path = named_file('world', name)
    return _world(read_yaml(path), str(path), path.parent)


def world_from(parameters: SimParameters) -> World:
    """Return the world of a run, from ``world``, ``contact.*`` and ``arm`` of the simulator."""
    world = with_contact(load_world(parameters.world), parameters.by_name())
    return with_tool(world, arm_tool(parameters.arm))


def with_tool(world: World, tool: list[Solid]) -> World:
    """Return a world with the tool of the arm's file, unless it has one of its own."""
    return world if world.tool else msgspec.structs.replace(world, tool=tool)


def with_contact(world: World, parameters: Mapping[str, Any]) -> World:
    """Return a world with the parameters ``contact.*`` in its bodies, -1 left out."""
    changes = {key: parameters[f'contact.{key}'] for key in _REPLACED
               if parameters[f'contact.{key}'] >= 0.0}
    if not changes:
        return world
    return msgspec.structs.replace(world, bodies=[
        msgspec.structs.replace(body, **changes) for body in world.bodies])


def parse_world(text: str, source: str) -> World:
    """Return a world from the text of its file, as stored in a bag; meshes are not looked for."""
    return _world(parse_yaml(text, source), source, None) if text else EMPTY_WORLD


def _world(data: Any, source: str, folder: Path | None) -> World:
    world = validate(World, data, source)
    names = [body.name for body in world.bodies]
    for i, body in enumerate(world.bodies):
        where = f'{source}: body {body.name}'
        if body.name in names[:i]:
            raise InputError(f'{where}: the name is there twice; give each body its own')
        check_shape(body, where)
        _check_mass(body, where)
    for i, solid in enumerate(world.tool):
        check_shape(solid, f'{source}: tool shape {i + 1}')
        if solid.shape in ('plane', 'mesh'):
            raise InputError(f'{source}: tool shape {i + 1} is a {solid.shape}; give sphere, '
                          'cylinder or box')
    return world if folder is None else _with_files(world, folder, source)


def _check_mass(body: Body, where: str) -> None:
    if not body.free:
        return
    if body.shape == 'plane':
        raise InputError(f'{where}: a plane has mass {body.mass:g} kg; leave mass out, or give a '
                         'box')
    if body.shape == 'mesh' and body.inertia is None:
        raise InputError(f'{where}: mass {body.mass:g} kg without inertia; give inertia: three '
                      'moments about the axes of the mesh [kg m^2]')
    xx, yy, zz = body.moments
    if max(xx, yy, zz) > (xx + yy + zz) / 2 * (1 + 1e-9):
        raise InputError(f'{where}: inertia {body.moments} is that of no body: one moment exceeds '
                      'the sum of the others; give three that do not')


def _with_files(world: World, folder: Path, source: str) -> World:
    """Return the world with absolute paths of meshes."""
    bodies = []
    for body in world.bodies:
        if body.file:
            path = (folder / Path(body.file).expanduser()).resolve()
            if not path.is_file():
                raise InputError(f'{source}: body {body.name}: no mesh {path}; give an OBJ or STL '
                              'file')
            body = msgspec.structs.replace(body, file=str(path))
        bodies.append(body)
    return msgspec.structs.replace(world, bodies=bodies)
