"""From bags to a verdict: run, metrics, checks, figures, report; needs neither ROS nor PyBullet."""
