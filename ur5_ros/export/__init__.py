"""A recorded run as files of other tools: tables and a scene."""
