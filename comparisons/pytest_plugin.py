"""Where the plugin was: for installations of before, whose entry point still names this place."""

pytest_plugins = ["roughline.pytest_plugin"]
