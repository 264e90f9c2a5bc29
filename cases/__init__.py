"""cases: scenes, geometry, console, files, pictures; the only place where the packages meet.

Nothing is imported here but `machine`: listing and checking scenes stays light.
"""

from .machine import keep_compiled_code

keep_compiled_code()
