// The sentences of BIP1 (compiler/docs/bip1.md has the sources), and the part of C that BIP2 can say. No actions.
parser grammar Bip1Parser;

options { tokenVocab = Bip1Lexer; contextSuperClass = TreeNode; }
@parser::preinclude { #include "compiler/parse/tree_node.hpp" }

file: MODEL id decl* END EOF;
decl: header | portType | connectorType | atomType | compoundType | instances;
header: HEADER block;

// ---- types --------------------------------------------------------------------------------------------------------------
portType: PORT TYPE id (LPAREN params? RPAREN)?;
connectorType: CONNECTOR TYPE id (LPAREN params? RPAREN)? connectorPart* END;
atomType: ATOMIC TYPE? id (LPAREN params? RPAREN)? atomItem* END;
compoundType: COMPOUND TYPE? id (LPAREN params? RPAREN)? compoundItem* END;
params: param (COMMA param)*;
param: typeName id;
typeName: block | id+ STAR*;
data: EXPORT? DATA (typeName var (COMMA var)* | block) SEMI?;
var: id (ASSIGN expr)?;

// ---- connectors -----------------------------------------------------------------------------------------------------------
connectorPart: data | portDecl | define | completeness | clause | BEHAVIOR clause* END;
define: DEFINE portTerm (COMMA? portTerm)*;
portTerm: (path | (LBRACK | LPAREN) portTerm (COMMA? portTerm)* (RBRACK | RPAREN)) PRIME?;
completeness: (COMPLETE | INCOMPLETE) (ASSIGN | COLON)? interaction (COMMA interaction)*;
interaction: path (PIPE path)*;
clause: ON path ((COMMA | PIPE)? path)* (provided | up | down | action)*;
up: UP block;
down: DOWN block;
provided: PROVIDED guard;
guard: block | expr;

// ---- atoms ----------------------------------------------------------------------------------------------------------------
atomItem: header | data | portDecl | clock | priority | initial | behavior;
portDecl: EXPORT? PORT (COMPLETE | INCOMPLETE)? id? portItem (COMMA portItem)* ((IS | AS | ASSIGN) id)?;
portItem: id (LPAREN idList? RPAREN)?;
clock: CLOCK idList (UNIT INT? id)?;
behavior: BEHAVIOR (initial | STATE id | PLACE idList | transition)* END;
initial: INITIAL (to | action)*;
transition: (ON id | INTERNAL) (from | provided | when | urgency | action | RESET idList | to)*;
from: FROM idList;
to: TO idList;
when: WHEN (path IN LBRACK expr COMMA expr RBRACK | guard);
urgency: LAZY | DELAYABLE | EAGER;
action: DO (block | simple SEMI?);

// ---- compounds --------------------------------------------------------------------------------------------------------------
compoundItem: instances | connectors | inlineConnector | priority | compoundExport;
instances: (COMPONENT | CONTAINS) id instance (COMMA instance)*;
instance: id (LPAREN args? RPAREN)?;
args: expr (COMMA expr)*;
connectors: CONNECTOR id binding (COMMA binding)*;
binding: id LPAREN (path (COMMA path)*)? RPAREN;
inlineConnector: CONNECTOR (binding | id ASSIGN path (COMMA path)*) connectorPart*;
priority: PRIORITY id? condition? (LPAREN prioritySide LT prioritySide RPAREN | prioritySide LT prioritySide) condition?;
condition: (PROVIDED | IF) (LPAREN expr RPAREN | block);
prioritySide: STAR (COLON STAR)? | path (COLON (STAR | path ((COMMA | PIPE) path)*))?;
compoundExport: EXPORT (PORT | DATA) path (path (LPAREN idList? RPAREN)?)? (IS | AS | ASSIGN) path;

// ---- C code -------------------------------------------------------------------------------------------------------------------
block: LBRACE codePart* RBRACE | RAW_OPEN codePart* RAW_CLOSE;
codePart: CODE_TEXT | RAW_TEXT | block;
code: stmt* simple? EOF;
stmt: simple SEMI | SEMI | ifStmt | block;
simple: path (ASSIGN | ARROW | CHANGE) expr | path (INC | DEC) | (INC | DEC) path | path LPAREN args? RPAREN;
ifStmt: IF LPAREN expr RPAREN stmt (ELSE stmt)?;
guardCode: expr SEMI? EOF;
dataCode: (typeName var (COMMA var)* SEMI?)* EOF;

expr:
  primary
  | (MINUS | PLUS | TILDE | BANG) expr
  | expr (STAR | SLASH | PERCENT) expr
  | expr (PLUS | MINUS) expr
  | expr (LT | GT | LE | GE) expr
  | expr (EQ | NE) expr
  | expr AMP expr
  | expr CARET expr
  | expr PIPE expr
  | expr ANDAND expr
  | expr OROR expr;
primary: INT | HEX | FLOAT | STRING | TRUE | FALSE | PRIME (id | INT) PRIME | path (LPAREN args? RPAREN)? | LPAREN expr RPAREN;

// ---- names ------------------------------------------------------------------------------------------------------------------------
path: id (DOT id)*;
idList: id (COMMA id)*;
id: ID | WHEN | RESET | IN | UNIT | LAZY | DELAYABLE | EAGER | AS;
