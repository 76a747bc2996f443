"""The exact torque as others compute it, and how long compiled code takes."""
