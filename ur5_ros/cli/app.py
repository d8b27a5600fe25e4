"""Every command of ``ur5`` with its options; each command imports what it needs."""

from ur5_ros.cli import judging, laws, tools
from ur5_ros.cli.typer_app import app

__all__ = ['app', 'judging', 'laws', 'tools']
