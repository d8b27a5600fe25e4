"""From bags to a verdict: run, checks, figures, report; needs neither ROS nor PyBullet."""
