/* What a platform gives to the tests. */
#ifndef CANBAUD_TEST_H
#define CANBAUD_TEST_H

/* Prints a text. */
void test_print(const char *text);

/* Runs all tests; the number of those that failed. */
unsigned test_run(void);

#endif
