"""What an identification found, as values and in words."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.identification.friction.families import Family
from ur5_ros.analysis.identification.motors import Motors
from ur5_ros.analysis.identification.payload import PayloadEstimate
from ur5_ros.analysis.identification.prediction import Prediction
from ur5_ros.analysis.identification.words import or_dash
from ur5_ros.analysis.result import plain
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES


class Identified(NamedTuple):
    """What was identified of an arm."""

    arm: ArmParameters
    """Physical parameters, as near as may be to the fit."""
    base: dict[str, tuple[float, float]]
    """Base parameter -> value and standard error; dependent ones are folded into them."""
    not_excited: tuple[str, ...]
    """Base parameters that the motion does not determine."""
    covariance: np.ndarray
    """Of the base parameters in :attr:`base`, in their order, shape (b, b)."""
    viscous: np.ndarray
    """Viscous friction [N m s/rad], shape (6,)."""
    viscous_error: np.ndarray
    coulomb: np.ndarray
    """Coulomb friction [N m], shape (6,)."""
    coulomb_error: np.ndarray
    family: tuple[Family, ...]
    """Family of friction that held-out motion confirms, joint by joint."""
    terms: tuple[dict[str, tuple[float, float]], ...]
    """Its parameters and their standard errors."""
    condition: float
    """Condition number of the scaled regressor."""
    moved: float
    """How far physical parameters are from the fit, in its standard errors; 0 = on it."""
    train: Prediction
    """The runs that were fitted."""
    test: Prediction
    """The run that the result was tried on."""
    motors: Motors | None
    """What motor currents give for friction, where they are recorded."""
    payload: PayloadEstimate | None
    """Load at the tool in the run that was given for it."""
    simulated: float
    """Largest tracking error of the arm under its own computed torque for 10 s [rad]."""

    @property
    def torque_rms(self) -> np.ndarray:
        """Return the torque of the test run, root mean square [N m], shape (6,)."""
        return self.test.torque_rms

    @property
    def test_rms(self) -> np.ndarray:
        """Return the error of the predicted torque on it, root mean square [N m], shape (6,)."""
        return self.test.error_rms

    @property
    def test_max(self) -> np.ndarray:
        """Return the largest error [N m], shape (6,)."""
        return self.test.error_max

    @property
    def test_run(self) -> str:
        """Return what it was tested on."""
        return self.test.run

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return plain({
            'format': 'ur5_ros identification', 'version': 1, 'arm': self.arm.name,
            'states': 'measured',
            'base_parameters': {name: {'value': value, 'error': error}
                                for name, (value, error) in self.base.items()},
            'covariance': self.covariance.tolist(),
            'not_excited': list(self.not_excited),
            'viscous_friction': _joints(self.viscous, self.viscous_error),
            'coulomb_friction': _joints(self.coulomb, self.coulomb_error),
            'friction': {name: {
                'family': family.name, 'held_out_rms': family.held_out,
                'held_out_rms_linear': family.held_out_linear,
                'held_out_rms_none': family.held_out_none,
                'terms': {term: {'value': value, 'error': error}
                          for term, (value, error) in terms.items()},
            } for name, family, terms in zip(JOINT_NAMES, self.family, self.terms, strict=True)},
            'condition': self.condition, 'moved_sigma': self.moved,
            'train': self.train.to_plain(), 'test': self.test.to_plain(),
            'motors': self.motors.to_plain() if self.motors else None,
            'payload': self.payload.to_plain() if self.payload else None,
            'simulated_error_max': self.simulated,
        })

    def sentences(self) -> list[str]:
        """Return the outcome in words."""
        if not self.base:
            return ['motor currents alone are recorded: bodies and rotors are those of the arm '
                    'that the fit began with, and none of them was identified',
                    *(self.motors.sentences() if self.motors else []), *self._of_drives(),
                    *([self.payload.sentence()] if self.payload else []), self._gate()]
        words = [f'{len(self.base)} base parameters from the measured states, condition number '
                 f'{self.condition:.3g}']
        if self.not_excited:
            words.append('not excited by this motion, left as in the arm that the fit began '
                         f'with: {", ".join(self.not_excited)}; record the experiment exciting, '
                         'or one made by ur5 excite')
        words += [self._predicted(), *self._families()]
        if self.moved > 3.0:
            words.append(f'the fit itself is no physical arm; the one written is {self.moved:.2g} '
                         f'standard errors away, and predicts {self.test.run} within '
                         f'{_list(self.test.error_rms)} N m where the fit has '
                         f'{_list(self.test.fit_rms)} N m')
        words += [*self.motors.sentences(), *self._of_drives()] if self.motors else []
        words += [self.payload.sentence()] if self.payload else []
        return [*words, self._gate()]

    def _predicted(self) -> str:
        """Return how well the test run is predicted, and which joints it does not tell about."""
        share = self.test.error_rms / np.where(self.test.torque_rms > 0.0, self.test.torque_rms,
                                               np.inf)
        known = np.isfinite(share)
        still = ', '.join(name for name, each in zip(JOINT_NAMES, known, strict=True) if not each)
        but = f' but {still}, which move too little there' if still else ''
        if not known.any():
            return f'no joint moves enough in {self.test.run} for its torque to be predicted'
        worst = int(np.nanargmax(share))
        return (f'torque predicted on {self.test.run} within {100 * share[worst]:.2g} % of its '
                f'RMS in every joint{but} (worst: {JOINT_NAMES[worst]})')

    def _gate(self) -> str:
        return (f'the arm follows a motion of 10 s under its own computed torque within '
                f'{self.simulated:.1g} rad')

    def _of_drives(self) -> list[str]:
        """Return which joints' drives have another friction than viscous and Coulomb."""
        families = self.motors.family if self.motors else ()
        return [f'{name}: friction {family.name}: {family.held_out:.3g} A RMS on motion left out, '
                f'{family.held_out_linear:.3g} with viscous and Coulomb alone'
                for name, family in zip(JOINT_NAMES, families, strict=False)
                if family is not None and len(family.features) > 2]

    def _families(self) -> list[str]:
        """Return which joints have another friction than viscous and Coulomb."""
        words = []
        for name, family in zip(JOINT_NAMES, self.family, strict=True):
            if len(family.features) > 2:
                words.append(f'{name}: friction {family.name}: {family.held_out:.3g} N m RMS on '
                             f'motion left out, {family.held_out_linear:.3g} with viscous and '
                             'Coulomb alone')
        return words


def _list(values: np.ndarray, digits: int = 2) -> str:
    return ', '.join(or_dash(value, digits) for value in values)


def _joints(value: np.ndarray, error: np.ndarray) -> dict[str, dict[str, float]]:
    return {name: {'value': float(v), 'error': float(e)}
            for name, v, e in zip(JOINT_NAMES, value, error, strict=True)}
