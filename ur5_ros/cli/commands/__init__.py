"""What each command of ``ur5`` does; imported when the command is used."""
